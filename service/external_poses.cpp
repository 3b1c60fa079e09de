// SPDX-License-Identifier: BSD-3-Clause
#include "service/external_poses.hpp"

#include <variant>

namespace slamfuse::service {

common::PoseSource ExternalPoses::source() const {
  return sensor_ == kVisualPose ? common::PoseSource::kVisual : common::PoseSource::kLaser;
}

bool ExternalPoses::wants(const common::SensorMessage& message) const {
  return std::holds_alternative<common::ExternalPose>(message) && common::sensor_of(message) == sensor_;
}

common::ProcessResult ExternalPoses::process(const common::SensorMessage& message) {
  const auto* pose = std::get_if<common::ExternalPose>(&message);
  if (pose == nullptr) return {};
  common::PoseEstimate estimate;
  estimate.stamp = pose->stamp;
  estimate.source = source();
  if (pose->frame != frame_ && path_.count() > 0) {
    ++epoch_;
    path_.clear();
    estimate.events.push_back({pose->stamp, common::to_string(source()), "map_reset",
                               "poses come in frame '" + pose->frame + "', before in '" + frame_ + "'"});
  }
  frame_ = pose->frame;
  estimate.map_epoch = epoch_;
  estimate.pose = pose->pose;
  estimate.covariance = pose->covariance.value_or(Eigen::Matrix3d::Zero());
  if (estimate.covariance.diagonal().minCoeff() <= 0.0) {
    const double position = options_.position_sigma * options_.position_sigma;
    const double heading = options_.heading_sigma * options_.heading_sigma;
    estimate.covariance = Eigen::Vector3d(position, position, heading).asDiagonal();
  }
  path_.push({pose->stamp, pose->pose});
  return {estimate, std::nullopt};
}

}  // namespace slamfuse::service
