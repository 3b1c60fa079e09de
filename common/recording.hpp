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
  Nanoseconds stamp = 0;  ///< as far as known, else that of the last good message
  std::string sensor;
  std::string reason;  ///< file and line, the value, what is allowed
};

using RecordingItem = std::variant<SensorMessage, RejectedMessage>;

enum class SensorKind { kOdometry, kLaser, kCamera, kImu };

/// What a recording knows of one of its sensors without reading all of it.
struct SensorInfo {
  SensorKind kind = SensorKind::kLaser;
  std::size_t messages = 0;
  Nanoseconds first_stamp = 0;
  Nanoseconds last_stamp = 0;
};

struct RecordingInfo {
  std::filesystem::path path;
  std::string format;  ///< "euroc", "carmen", "rawlog", "images"
  std::map<std::string, SensorInfo> sensors;
  Calibration calibration;
  /// Whether messages come in the order of their stamps. A CARMEN log comes in file order and stamps may step back.
  bool stamp_ordered = true;
  Nanoseconds first_stamp = 0;  ///< smallest over all sensors
  Nanoseconds last_stamp = 0;   ///< largest over all sensors
};

/// A recording being read from front to back, lazily, all sensors merged in time order (or file order, see
/// RecordingInfo).
class Recording {
 public:
  virtual ~Recording() = default;
  virtual const RecordingInfo& info() const = 0;
  /// The next message or rejected message; empty at the end. An error means the structure itself became unreadable.
  virtual Result<std::optional<RecordingItem>> next() = 0;
};

/// Opens a recording, recognised by its content (DESIGN section 5): an EuRoC/ASL folder, a folder of images with
/// `sensor.yaml`, a CARMEN log (plain, gzip, bzip2), an MRPT rawlog. Errors (kInvalidInput): no such path, no known
/// format, no sensor with a message, sensors that have no time in common.
Result<std::unique_ptr<Recording>> open_recording(const std::filesystem::path& path);

/// True poses of base_link that lie beside the recording, empty when there are none. For evaluation only: never hand
/// them to an estimator.
Result<Trajectory2> read_ground_truth(const std::filesystem::path& path);

}  // namespace slamfuse::common
