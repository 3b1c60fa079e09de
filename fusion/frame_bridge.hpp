// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "common/time.hpp"
#include "fusion/alignment.hpp"
#include "fusion/bend_tracker.hpp"
#include "fusion/odometry_drift.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// The way between the visual and the laser map frame at the place where the robot is: the alignment of the whole drive
/// (G_LV) and the bend of the maps against each other here.
class FrameBridge {
 public:
  FrameBridge(const BendOptions& bend, const OdometryDriftOptions& drift) : bend_(bend), drift_(drift) {}

  /// The robot was moved by other than its wheels, or one of the maps is new: the bend is unknown again.
  void forget_place();
  /// Uses this alignment from now on; the poses it gives here stay where they were. Nothing closes the bridge.
  void use(const std::optional<Alignment>& alignment);
  /// As CorrectedPoseFilter::change_odometry_frame.
  void change_odometry_frame(const common::Pose2& T_new_old);

  /// A laser pose (in the laser map frame) that was used, measured when odometry stood at `T_odom_base`.
  void laser_told(common::Nanoseconds stamp, const UncertainPose& laser, const common::Pose2& T_odom_base);
  /// A visual pose (in the visual map frame) in the laser map frame; nothing without an alignment. Where the laser told
  /// its pose at about the same time, the bend follows it within `gate`.
  std::optional<UncertainPose> to_laser(common::Nanoseconds stamp, const UncertainPose& visual,
                                        const common::Pose2& T_odom_base, double gate);
  /// A pose of the laser map frame in the visual one, for setting the visual half's pose; nothing without an alignment.
  std::optional<UncertainPose> to_visual(const UncertainPose& laser) const;

 private:
  struct Told {
    common::Nanoseconds stamp = 0;
    UncertainPose pose;
    common::Pose2 T_odom_base;
  };

  /// The laser's pose at the time and odometry pose of a visual one.
  std::optional<UncertainPose> laser_at(common::Nanoseconds stamp, const common::Pose2& T_odom_base) const;
  Eigen::Matrix3d spread(const common::Pose2& visual) const;

  BendTracker bend_;
  OdometryDriftOptions drift_;
  std::optional<Alignment> alignment_;
  std::deque<Told> told_;
  std::optional<Told> last_visual_;  ///< the visual pose last brought over, in the visual frame
  bool place_known_ = false;         ///< whether the bend was started at this place
  Eigen::Matrix3d laser_covariance_ = Eigen::Matrix3d::Zero();  ///< of the laser pose the bend last followed
};

}  // namespace slamfuse::fusion
