// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/sensor_message.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// A message that was in the recording but cannot be used: a cut image, an impossible scan, a stamp that repeats. It is
/// dropped, counted and told; the run goes on.
struct RejectedMessage {
  Nanoseconds stamp = 0;  ///< as far as known, else that of the last good message, else the recording's first
  std::string sensor;
  std::string reason;  ///< file and line, the value, what is allowed
};

using RecordingItem = std::variant<SensorMessage, RejectedMessage>;

enum class SensorKind { kOdometry, kLaser, kCamera, kImu, kPose };

/// What a recording knows of one of its sensors without reading all of it.
struct SensorInfo {
  SensorKind kind = SensorKind::kLaser;
  std::size_t messages = 0;  ///< with a usable stamp; some may still be rejected when their turn comes
  Nanoseconds first_stamp = 0;
  Nanoseconds last_stamp = 0;
};

struct RecordingInfo {
  std::filesystem::path path;
  std::string format;  ///< "euroc", "carmen", "rawlog", "images", "ros1", "ros2"
  std::map<std::string, SensorInfo> sensors;
  Calibration calibration;
  /// Whether stamps tell the true order: those of every sensor rise. A CARMEN log comes in file order, which is the
  /// true one, while its stamps may repeat and step back. (Late arrival, see replay.hpp, does not change this.)
  bool stamp_ordered = true;
  Nanoseconds first_stamp = 0;  ///< smallest over all sensors
  Nanoseconds last_stamp = 0;   ///< largest over all sensors
  /// What was chosen or assumed where the recording left it open, one sentence each.
  std::vector<std::string> notes;
};

/// What a user tells of a recording that it does not tell itself. For ROS bags only, see choose_ros_topics().
struct RecordingOptions {
  /// Topics by sensor name ("laser0", "odom0", "cam0", ...) or "truth"; "none" leaves it out. Naming one sensor of a
  /// kind leaves out all others of that kind.
  std::map<std::string, std::string> topics;
  std::string base_frame;  ///< the frame whose pose is sought; empty: guessed

  bool empty() const { return topics.empty() && base_frame.empty(); }
};

/// A recording being read from front to back, lazily, all sensors merged in time order (or in file order where the
/// format is one file).
class Recording {
 public:
  virtual ~Recording() = default;
  virtual const RecordingInfo& info() const = 0;
  /// The next message or rejected message; empty at the end. An error means the structure itself became unreadable.
  virtual Result<std::optional<RecordingItem>> next() = 0;
};

/// Opens a recording, recognised by its content (DESIGN section 5): an EuRoC/ASL folder, a folder of images with
/// `sensor.yaml`, a CARMEN log (plain, gzip, bzip2), an MRPT rawlog, a ROS 2 bag (SQLite or MCAP, folder or file), a
/// ROS 1 bag. Errors (kInvalidInput): no such path, no known format, no sensor with a message, sensors that have no
/// time in common. Errors (kUsage): options that do not fit the recording.
Result<std::unique_ptr<Recording>> open_recording(const std::filesystem::path& path,
                                                  const RecordingOptions& options = {});

/// Whether a path is a ROS bag: only a bag's topics and frames can be chosen.
bool is_ros_bag(const std::filesystem::path& path);

/// True poses that lie beside or in the recording, empty when there are none: of base_link the
/// `state_groundtruth_estimate0` of an EuRoC folder and the `NAME.reference.txt` of a CARMEN log, of the tracked body
/// the motion capture in a ROS bag. For evaluation only: never hand them to an estimator. Error (kInvalidInput): they
/// are there and cannot be read. Error (kUsage): options that do not fit the recording.
Result<Trajectory2> read_ground_truth(const std::filesystem::path& path, const RecordingOptions& options = {});

}  // namespace slamfuse::common
