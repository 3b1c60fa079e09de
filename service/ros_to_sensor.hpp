// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/error.hpp"
#include "common/ros_messages.hpp"
#include "idl/messages.hpp"

namespace slamfuse::service {

/// Messages as they came from the network, checked, in the form in which common/ros_conversions.hpp takes them. Errors
/// (kInvalidInput), the reason alone: a stamp that is no time, numbers that are not finite, a quaternion that is not of
/// unit length. Spans refer to the message.
common::Result<common::RosLaserScan> from_ros(const idl::LaserScan& message);
common::Result<common::RosOdometry> from_ros(const idl::Odometry& message);
common::Result<common::RosImage> from_ros(const idl::Image& message);
common::Result<common::RosCompressedImage> from_ros(const idl::CompressedImage& message);
common::Result<common::RosCameraInfo> from_ros(const idl::CameraInfo& message);
common::Result<std::vector<common::RosTransform>> from_ros(const idl::TFMessage& message);

/// A pose somebody else found.
struct RosPose {
  common::RosHeader header;
  std::string child_frame;  ///< whose pose it is; empty: not told
  common::Pose3 pose;
  std::optional<Eigen::Matrix3d> covariance;  ///< of (x, y, theta) [m^2, m rad, rad^2]; empty: not told
};
/// Further errors: a covariance that is not finite, or has a negative variance.
common::Result<RosPose> from_ros(const idl::PoseWithCovarianceStamped& message);
common::Result<RosPose> from_ros(const idl::PoseStamped& message);
/// The pose of an odometry message with its covariance.
common::Result<RosPose> pose_from_ros(const idl::Odometry& message);

}  // namespace slamfuse::service
