// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_slam.hpp"

#include <utility>

#include "common/odometry_buffer.hpp"

namespace slamfuse::laser_slam {

/// Dead reckoning only: a first state of the interface.
class LaserSlam::Impl {
 public:
  std::string sensor;
  common::OdometryBuffer odometry;
  common::Trajectory2 path;
};

LaserSlam::LaserSlam(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LaserSlam::~LaserSlam() = default;

common::Result<std::unique_ptr<LaserSlam>> LaserSlam::create(const LaserSlamOptions&, const std::string& sensor,
                                                             const common::LaserCalibration&, std::uint64_t, int) {
  auto impl = std::make_unique<Impl>();
  impl->sensor = sensor;
  return std::unique_ptr<LaserSlam>(new LaserSlam(std::move(impl)));
}

bool LaserSlam::wants(const common::SensorMessage& message) const {
  if (std::holds_alternative<common::WheelOdometry>(message)) return true;
  return std::holds_alternative<common::LaserScan>(message) && common::sensor_of(message) == impl_->sensor;
}

common::ProcessResult LaserSlam::process(const common::SensorMessage& message) {
  common::ProcessResult result;
  if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) impl_->odometry.add(*odometry);
  if (std::holds_alternative<common::LaserScan>(message)) {
    common::PoseEstimate estimate;
    estimate.stamp = common::stamp_of(message);
    estimate.pose = impl_->odometry.pose_at(estimate.stamp).value_or(common::Pose2{});
    estimate.covariance = Eigen::Matrix3d::Identity() * 0.01;
    impl_->path.push_back({estimate.stamp, estimate.pose});
    result.estimate = estimate;
  }
  return result;
}

void LaserSlam::execute(const common::Command&) {}
common::Trajectory2 LaserSlam::final_trajectory() const { return impl_->path; }
common::OccupancyGrid LaserSlam::grid() const { return {}; }
common::Result<std::string> LaserSlam::serialize() const { return common::failed("laser_slam: nothing mapped yet"); }
common::Result<void> LaserSlam::restore(const std::string&) {
  return common::invalid_input("laser_slam: not a laser state");
}

}  // namespace slamfuse::laser_slam
