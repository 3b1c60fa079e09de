// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/error.hpp"
#include "common/ros_messages.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// A topic of a bag. One name with two types makes two.
struct RosTopic {
  std::string name;
  std::string type;  ///< as in ROS 1, e.g. "sensor_msgs/LaserScan"
};

/// A message of a bag, still serialised.
struct RosBagMessage {
  std::size_t topic = 0;   ///< index into RosBag::topics()
  Nanoseconds stored = 0;  ///< when it was received by who recorded it
  std::span<const std::uint8_t> data;
};

/// A place of a bag that cannot be read; the reason names the file.
struct RosBagDamage {
  std::string reason;
};

using RosBagItem = std::variant<RosBagMessage, RosBagDamage>;

/// A bag of ROS messages, read in the order in which they were received.
class RosBag {
 public:
  virtual ~RosBag() = default;
  virtual RosEncoding encoding() const = 0;
  virtual const std::vector<RosTopic>& topics() const = 0;
  /// Goes back to the beginning; from there on only messages of these topics come.
  virtual void rewind(const std::set<std::size_t>& topics) = 0;
  /// The next message, its data valid until the next call, or a place that cannot be read: what follows is then what
  /// could still be found behind it. Empty at the end.
  virtual std::optional<RosBagItem> next() = 0;
};

/// Most bytes of one message or one decompressed chunk; larger ones are damage.
inline constexpr std::size_t kLargestBagBlock = std::size_t{1} << 28;

/// Whether the beginning of a file is that of a ROS 1 bag, version 2.0.
bool is_ros1_bag(std::string_view beginning);
/// Opens one; its chunks may be plain, bz2 or lz4. The file is read through once for where its messages stand: the
/// index at its end is not needed, so a bag that was never closed can be read too. Error (kInvalidInput): unreadable,
/// or damaged so that no message is found.
Result<std::unique_ptr<RosBag>> open_ros1_bag(const std::filesystem::path& path);

/// Whether the beginning of a file is that of an MCAP file.
bool is_mcap_file(std::string_view beginning);
/// Opens a bag of MCAP files, of either ROS; their chunks may be plain, lz4 or zstd. The files are read through once
/// for where their messages stand, as in a ROS 1 bag. Error (kInvalidInput): no MCAP, unreadable, or damaged so that no
/// message is found.
Result<std::unique_ptr<RosBag>> open_mcap_bag(const std::vector<std::filesystem::path>& files);

/// Whether the beginning of a file is that of an SQLite database.
bool is_sqlite_file(std::string_view beginning);
/// Whether a folder holds a ROS 2 bag: rosbag2's metadata.yaml, or .db3 or .mcap files.
bool is_ros2_bag_folder(const std::filesystem::path& path);
/// Opens a ROS 2 bag: its folder (the files metadata.yaml names, else all .db3 or all .mcap), one .db3 or one .mcap
/// file. Error (kInvalidInput): no such files, no bag in them, another storage, compressed messages or files, not CDR.
Result<std::unique_ptr<RosBag>> open_ros2_bag(const std::filesystem::path& path);

}  // namespace slamfuse::common
