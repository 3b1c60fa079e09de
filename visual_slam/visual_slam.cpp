// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/visual_slam.hpp"

#include "common/odometry_buffer.hpp"

namespace slamfuse::visual_slam {

using common::Pose2;

/// The wheel odometry alone, until the filter stands behind this interface.
class VisualSlam::Implementation {
 public:
  explicit Implementation(std::map<std::string, common::CameraCalibration> cameras) : cameras_(std::move(cameras)) {}

  bool wants(const common::SensorMessage& message) const {
    if (const auto* image = std::get_if<common::Image>(&message)) return cameras_.contains(image->sensor);
    return std::holds_alternative<common::WheelOdometry>(message);
  }

  common::ProcessResult process(const common::SensorMessage& message) {
    if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) odometry_.add(*odometry);
    const auto* image = std::get_if<common::Image>(&message);
    if (image == nullptr || !cameras_.contains(image->sensor)) return {};
    const std::optional<Pose2> odometry_pose = odometry_.pose_at(image->stamp);
    if (!odometry_pose) return {.estimate = {}, .rejected = "no wheel odometry at the stamp of this image"};
    if (!origin_) origin_ = odometry_pose->inverse();
    common::PoseEstimate estimate;
    estimate.stamp = image->stamp;
    estimate.source = common::PoseSource::kVisual;
    estimate.map_epoch = epoch_;
    estimate.pose = *origin_ * *odometry_pose;
    estimate.covariance = 1e-4 * Eigen::Matrix3d::Identity();
    path_.push_back({image->stamp, estimate.pose});
    return {.estimate = estimate, .rejected = {}};
  }

  void execute(const common::Command& command) {
    if (std::holds_alternative<common::Reset>(command)) {
      ++epoch_;
      origin_.reset();
    }
  }

  const common::Trajectory2& path() const { return path_; }

 private:
  std::map<std::string, common::CameraCalibration> cameras_;
  common::OdometryBuffer odometry_;
  std::optional<Pose2> origin_;
  std::uint32_t epoch_ = 0;
  common::Trajectory2 path_;
};

common::Result<std::unique_ptr<VisualSlam>> VisualSlam::create(
    const VisualSlamOptions&, const std::map<std::string, common::CameraCalibration>& cameras, std::uint64_t, int) {
  if (cameras.empty()) return common::invalid_input("visual SLAM: no camera");
  return std::unique_ptr<VisualSlam>(new VisualSlam(std::make_unique<Implementation>(cameras)));
}

VisualSlam::VisualSlam(std::unique_ptr<Implementation> implementation) : implementation_(std::move(implementation)) {}
VisualSlam::~VisualSlam() = default;

bool VisualSlam::wants(const common::SensorMessage& message) const { return implementation_->wants(message); }
common::ProcessResult VisualSlam::process(const common::SensorMessage& message) {
  return implementation_->process(message);
}
void VisualSlam::execute(const common::Command& command) { implementation_->execute(command); }
common::Trajectory2 VisualSlam::final_trajectory() const { return implementation_->path(); }
std::vector<common::Landmark> VisualSlam::landmarks() const { return {}; }

}  // namespace slamfuse::visual_slam
