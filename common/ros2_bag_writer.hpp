// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "common/error.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// A topic of a bag being written.
struct BagTopic {
  std::string name;          ///< with its leading slash, as rosbag2 writes it
  std::string type;          ///< "sensor_msgs/msg/LaserScan"
  std::string qos_profiles;  ///< YAML of what its publishers offer, as rosbag2 keeps it; may be empty
};

/// Writes a ROS 2 bag: a folder with rosbag2's metadata.yaml (version 5) and one SQLite database in rosbag2's layout,
/// as `ros2 bag play` and open_ros2_bag() read it. Messages are committed every second, so a writer that is killed
/// leaves a database that can be read, without metadata.yaml.
class Ros2BagWriter {
 public:
  /// Makes the folder. Errors: it exists (kUsage), it cannot be made or written to (kInvalidInput).
  static Result<std::unique_ptr<Ros2BagWriter>> create(const std::filesystem::path& folder);
  /// Closes, if that has not been done.
  ~Ros2BagWriter();

  /// A number for write(). Error (kFailed): the disk is full or so.
  Result<std::size_t> add_topic(const BagTopic& topic);
  /// A message as it was received [Unix time, ns]: encapsulation header and CDR. Error as of add_topic().
  Result<void> write(std::size_t topic, Nanoseconds received, std::span<const std::uint8_t> data);
  /// Ends the bag and writes metadata.yaml. Error as of add_topic().
  Result<void> close();

  /// Messages written.
  std::size_t messages() const;

 private:
  struct State;
  explicit Ros2BagWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::common
