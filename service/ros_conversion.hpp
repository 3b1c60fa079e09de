// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/landmark.hpp"
#include "common/occupancy_grid.hpp"
#include "common/pose2.hpp"
#include "common/time.hpp"
#include "common/trajectory.hpp"
#include "fusion/status.hpp"
#include "idl/message.hpp"

namespace slamfuse::service {

/// What every ROS message starts with.
struct RosHeader {
  common::Nanoseconds stamp = 0;
  std::string frame;
};

/// A stamp as ROS splits it: whole seconds rounded down, nanoseconds 0 .. 999999999. Seconds beyond 32 bits (2038)
/// saturate.
idl::Time to_ros_time(common::Nanoseconds stamp);
/// The stamp a ROS time stands for.
common::Nanoseconds from_ros_time(const idl::Time& time);

/// A turn about z.
idl::Quaternion yaw_to_quaternion(double yaw);
/// The turn about z of a unit quaternion, in (-pi, pi].
double quaternion_to_yaw(const idl::Quaternion& quaternion);

/// The row-major 6x6 covariance over (x, y, z, roll, pitch, yaw) of a 3x3 one over (x, y, theta). What a planar pose
/// does not have gets variance 0, as from Nav2's AMCL.
std::array<double, 36> to_ros_covariance(const Eigen::Matrix3d& covariance);

idl::Message<idl::PoseWithCovarianceStamped> to_ros_pose(const RosHeader& header, const common::Pose2& pose,
                                                         const Eigen::Matrix3d& covariance);

/// One transform: the pose of `child` in the header's frame.
idl::Message<idl::TFMessage> to_ros_transform(const RosHeader& header, const std::string& child,
                                              const common::Pose2& pose);

/// The cells as they are: ROS uses the same values and order.
idl::Message<idl::OccupancyGrid> to_ros_grid(const RosHeader& header, const common::OccupancyGrid& grid);

/// A path of at most `max_poses` (>= 2) poses: longer ones are thinned evenly and keep their last pose.
idl::Message<idl::Path> to_ros_path(const RosHeader& header, const common::Trajectory2& path, std::size_t max_poses);

/// Points with x, y, z and intensity (the gray value, 0..255) as 32-bit floats. Positions must already be in the
/// header's frame; those that are not finite are left out.
idl::Message<idl::PointCloud2> to_ros_cloud(const RosHeader& header, const std::vector<common::Landmark>& landmarks);

/// The latest verdicts: the one on the fused pose in front, the halves' in `sources`.
idl::Message<idl::FusionStatus> to_ros_status(const RosHeader& header, const std::vector<fusion::StatusEntry>& latest);

}  // namespace slamfuse::service
