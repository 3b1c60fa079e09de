// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// Who made a pose. The order breaks ties when the fusion merges two poses made from the same input.
enum class PoseSource { kOdometry = 0, kLaser = 1, kVisual = 2, kFused = 3 };

/// What an estimator says about itself.
enum class TrackingState { kTracking, kUncertain, kLost };

/// "odometry", "laser", "visual", "fused": as in file names and metrics.json.
std::string to_string(PoseSource source);
/// "TRACKING", "UNCERTAIN", "LOST": as in status.csv.
std::string to_string(TrackingState state);

/// Something worth telling a person or another module, at most a few per minute.
struct Event {
  Nanoseconds stamp = 0;
  std::string module;  ///< "laser", "visual", "fusion", "recording"
  std::string kind;    ///< "loop_closed", "lost", "relocalised", "map_reset", "rejected", "degenerate", "aligned", ...
  std::string detail;  ///< in words, with figures
};

/// The figures behind a TrackingState. What a module does not measure stays empty.
struct Health {
  std::optional<double> scan_likelihood;      ///< mean agreement of the scan's beams with the map, 0..1
  std::optional<double> effective_particles;  ///< 1 / sum w^2
  std::optional<double>
      degenerate_direction;             ///< heading [rad] in the map frame along which the scan does not constrain
  std::optional<int> tracked_features;  ///< features matched to the map in this image
  std::optional<int> inliers;           ///< of those, accepted by the gates
  std::optional<double> innovation;     ///< mean normalised innovation squared per degree of freedom, ~1 when right
};

/// A pose of base_link in the map frame of its source, as known at this moment.
struct PoseEstimate {
  Nanoseconds stamp = 0;  ///< of the measurement the pose belongs to
  PoseSource source = PoseSource::kLaser;
  std::uint32_t map_epoch = 0;  ///< a reset or reload of the map starts a new one; poses of different epochs never mix
  Pose2 pose;                   ///< T_map_base
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of (x, y, theta) in the map frame [m^2, m rad, rad^2]
  TrackingState state = TrackingState::kTracking;
  Health health;
  std::vector<Event> events;
};

}  // namespace slamfuse::common
