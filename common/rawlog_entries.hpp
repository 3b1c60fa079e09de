// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// A planar range scan of an MRPT rawlog with the geometry that it states, unchecked. Readings run with rising bearing
/// whichever way the laser turns.
struct RawlogScan {
  std::optional<Nanoseconds> stamp;
  std::string label;             ///< of the sensor, may be empty
  LaserCalibration geometry;     ///< a rawlog tells no shortest range and no sweep duration
  std::vector<double> readings;  ///< [m]
  std::vector<bool> valid;       ///< as many; what the driver made of the readings
};

/// Absolute odometry, unchecked.
struct RawlogOdometry {
  std::optional<Nanoseconds> stamp;
  Pose2 pose;
  double forward_speed = 0.0;  ///< [m/s], 0 where the log does not tell
  double turn_rate = 0.0;      ///< [rad/s], 0 where the log does not tell
};

/// The robot's motion since the action before, by odometry.
struct RawlogAction {
  Pose2 step;
  double forward_speed = 0.0;
  double turn_rate = 0.0;
};

/// The observations of a sensory frame, or a single one that stands for itself; what is neither scan nor odometry is
/// left out.
struct RawlogObservations {
  bool is_frame = false;
  std::vector<std::variant<RawlogScan, RawlogOdometry>> observations;
};

using RawlogEntry = std::variant<RawlogObservations, RawlogAction>;

/// Reads the entries of an MRPT rawlog (plain or gzip) from front to back through MRPT, which stays behind this class.
class RawlogEntries {
 public:
  /// Errors as open_byte_source.
  static Result<RawlogEntries> open(const std::filesystem::path& path);

  RawlogEntries(RawlogEntries&&) noexcept;
  RawlogEntries& operator=(RawlogEntries&&) noexcept;
  ~RawlogEntries();

  /// The next entry; empty at the end. Error (kInvalidInput), the reason alone: the data is damaged, ends within an
  /// entry or holds one of a kind MRPT does not know; nothing behind it can be found.
  Result<std::optional<RawlogEntry>> next();

 private:
  class Archive;
  explicit RawlogEntries(std::unique_ptr<Archive> archive);

  std::unique_ptr<Archive> archive_;
};

}  // namespace slamfuse::common
