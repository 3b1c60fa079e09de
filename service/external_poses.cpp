// SPDX-License-Identifier: BSD-3-Clause
#include "service/external_poses.hpp"

#include <utility>
#include <variant>

namespace slamfuse::service {
namespace {

const std::string kMapReset = "map_reset";

}  // namespace

common::PoseSource ExternalPoses::source() const {
  return sensor_ == kVisualPose ? common::PoseSource::kVisual : common::PoseSource::kLaser;
}

bool ExternalPoses::wants(const common::SensorMessage& message) const {
  return std::holds_alternative<common::ExternalPose>(message) && common::sensor_of(message) == sensor_;
}

std::optional<common::Event> ExternalPoses::news_in(const common::ExternalPose& pose) {
  const bool first = publishers_.empty();
  const std::string before = std::exchange(frame_, pose.frame);
  const bool restarted = publishers_.insert(pose.publisher).second;
  if (first) return std::nullopt;
  const std::string half = common::to_string(source());
  if (pose.frame != before) {
    return common::Event{pose.stamp, half, kMapReset,
                         "poses come in frame '" + pose.frame + "', before in '" + before + "'"};
  }
  const AfterRestart kept = source() == common::PoseSource::kLaser ? options_.laser_restart : options_.visual_restart;
  if (!restarted) return std::nullopt;
  return common::Event{pose.stamp, half, kept == AfterRestart::kNewMap ? kMapReset : kRestarted,
                       "poses come from another publisher than before"};
}

common::ProcessResult ExternalPoses::process(const common::SensorMessage& message) {
  const auto* pose = std::get_if<common::ExternalPose>(&message);
  if (pose == nullptr) return {};
  common::PoseEstimate estimate;
  estimate.stamp = pose->stamp;
  estimate.source = source();
  if (const auto news = news_in(*pose)) {
    if (news->kind == kMapReset) {
      ++epoch_;
      path_.clear();
    } else {
      restarted_at_ = pose->stamp;
    }
    estimate.events.push_back(*news);
  }
  estimate.map_epoch = epoch_;
  estimate.pose = pose->pose;
  estimate.covariance = pose->covariance.value_or(Eigen::Matrix3d::Zero());
  if (estimate.covariance.diagonal().minCoeff() <= 0.0) {
    const double position = options_.position_sigma * options_.position_sigma;
    const double heading = options_.heading_sigma * options_.heading_sigma;
    estimate.covariance = Eigen::Vector3d(position, position, heading).asDiagonal();
  }
  if (restarted_at_ && pose->stamp < *restarted_at_ + common::from_seconds(options_.restart_settle)) {
    estimate.state = common::TrackingState::kLost;
    return {estimate, std::nullopt};
  }
  restarted_at_.reset();
  path_.push({pose->stamp, pose->pose});
  return {estimate, std::nullopt};
}

}  // namespace slamfuse::service
