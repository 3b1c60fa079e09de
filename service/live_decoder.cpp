// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_decoder.hpp"

#include <utility>
#include <variant>

#include "common/ros_conversions.hpp"

namespace slamfuse::service {

using common::Result;
using common::SensorKind;
using common::SensorMessage;

namespace {

Result<SensorMessage> to_image(const common::RosHeader& header, const std::string& sensor,
                               Result<common::GrayImage> gray) {
  if (!gray) return tl::unexpected(gray.error());
  return common::Image{header.stamp, sensor, gray->size.width, gray->size.height, std::move(gray->pixels)};
}

}  // namespace

Result<SensorMessage> LiveDecoder::decode(const LivePayload& payload, const std::string& sensor) const {
  return std::visit([&](const auto& message) { return this->decode(*message, sensor); }, payload);
}

Result<SensorMessage> LiveDecoder::decode(const idl::LaserScan& message, const std::string& sensor) const {
  const auto scan = from_ros(message);
  if (!scan) return tl::unexpected(scan.error());
  return common::to_laser_scan(*scan, sensor, info_.calibration.lasers.at(sensor));
}

Result<SensorMessage> LiveDecoder::decode(const idl::Odometry& message, const std::string& sensor) const {
  if (info_.sensors.at(sensor).kind == SensorKind::kPose) return to_pose(pose_from_ros(message), sensor);
  const auto odometry = from_ros(message);
  if (!odometry) return tl::unexpected(odometry.error());
  return common::to_wheel_odometry(*odometry, sensor, T_child_base_.at(sensor));
}

Result<SensorMessage> LiveDecoder::decode(const idl::Image& message, const std::string& sensor) const {
  const auto image = from_ros(message);
  if (!image) return tl::unexpected(image.error());
  return to_image(image->header, sensor, common::to_gray(*image, size_of(sensor)));
}

Result<SensorMessage> LiveDecoder::decode(const idl::CompressedImage& message, const std::string& sensor) const {
  const auto image = from_ros(message);
  if (!image) return tl::unexpected(image.error());
  return to_image(image->header, sensor, common::decode_gray_image(image->data, size_of(sensor)));
}

Result<SensorMessage> LiveDecoder::decode(const idl::PoseWithCovarianceStamped& message,
                                          const std::string& sensor) const {
  return to_pose(from_ros(message), sensor);
}

Result<SensorMessage> LiveDecoder::decode(const idl::PoseStamped& message, const std::string& sensor) const {
  return to_pose(from_ros(message), sensor);
}

Result<SensorMessage> LiveDecoder::decode(const idl::CameraInfo& /*message*/, const std::string& /*sensor*/) {
  return common::invalid_input("not a sensor message");
}

Result<SensorMessage> LiveDecoder::decode(const idl::TFMessage& /*message*/, const std::string& /*sensor*/) {
  return common::invalid_input("not a sensor message");
}

Result<SensorMessage> LiveDecoder::to_pose(const Result<RosPose>& pose, const std::string& sensor) const {
  if (!pose) return tl::unexpected(pose.error());
  const common::Pose2 T_map_base = common::to_pose2(pose->pose) * T_child_base_.at(sensor);
  return common::ExternalPose{pose->header.stamp, sensor, pose->header.frame, T_map_base, pose->covariance};
}

common::ImageSize LiveDecoder::size_of(const std::string& camera) const {
  const common::CameraCalibration& calibration = info_.calibration.cameras.at(camera);
  return {calibration.width, calibration.height};
}

}  // namespace slamfuse::service
