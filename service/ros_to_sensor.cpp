// SPDX-License-Identifier: BSD-3-Clause
#include "service/ros_to_sensor.hpp"

#include <cmath>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "common/wire_reader.hpp"
#include "idl/message.hpp"
#include "service/ros_conversion.hpp"

namespace slamfuse::service {
namespace {

using common::Result;

std::string frame_of(const char* field) { return common::plain_frame(idl::text_of(field)); }

Result<common::RosHeader> header_of(const idl::Header& header) {
  constexpr std::uint32_t kNanosecondsEnd = 1'000'000'000;
  if (header.stamp.sec < 0 || header.stamp.nanosec >= kNanosecondsEnd) {
    return common::invalid_input(
        fmt::format("stamp of {} s and {} ns is no time", header.stamp.sec, header.stamp.nanosec));
  }
  return common::RosHeader{from_ros_time(header.stamp), frame_of(header.frame_id)};
}

Result<common::Pose3> pose_of(double x, double y, double z, const idl::Quaternion& q) {
  common::Pose3 pose{{x, y, z}, {q.w, q.x, q.y, q.z}};
  if (auto checked = common::normalise(pose); !checked) return tl::unexpected(checked.error());
  return pose;
}

/// The planar part of a covariance over (x, y, z, roll, pitch, yaw).
Result<Eigen::Matrix3d> covariance_of(const double (&covariance)[36]) {
  constexpr int kPlanar[] = {0, 1, 5};
  constexpr int kSize = 6;
  Eigen::Matrix3d planar;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      planar(row, column) = covariance[kSize * kPlanar[row] + kPlanar[column]];
    }
    if (planar(row, row) < 0.0) return common::invalid_input("a negative variance");
  }
  if (!planar.allFinite()) return common::invalid_input("a covariance that is not finite");
  return Eigen::Matrix3d(0.5 * (planar + planar.transpose()));
}

Result<RosPose> pose_of(const idl::Header& from, const char* child, const idl::Pose& pose,
                        const double (*covariance)[36]) {
  auto header = header_of(from);
  if (!header) return tl::unexpected(header.error());
  const auto read = pose_of(pose.position.x, pose.position.y, pose.position.z, pose.orientation);
  if (!read) return tl::unexpected(read.error());
  RosPose result{*std::move(header), frame_of(child), *read, std::nullopt};
  if (covariance == nullptr) return result;
  const auto planar = covariance_of(*covariance);
  if (!planar) return tl::unexpected(planar.error());
  result.covariance = *planar;
  return result;
}

template <class Sequence>
auto span_of(const Sequence& sequence) {
  return std::span(static_cast<const std::remove_pointer_t<decltype(sequence._buffer)>*>(sequence._buffer),
                   sequence._length);
}

template <class Item>
std::vector<Item> list_of(std::span<const Item> items) {
  return {items.begin(), items.end()};
}

}  // namespace

Result<common::RosLaserScan> from_ros(const idl::LaserScan& message) {
  return header_of(message.header).map([&](common::RosHeader&& header) {
    return common::RosLaserScan{
        std::move(header),      message.angle_min, message.angle_max, message.angle_increment,
        message.time_increment, message.range_min, message.range_max, list_of(span_of(message.ranges))};
  });
}

Result<common::RosOdometry> from_ros(const idl::Odometry& message) {
  auto header = header_of(message.header);
  if (!header) return tl::unexpected(header.error());
  const auto& position = message.pose.pose.position;
  const auto pose = pose_of(position.x, position.y, position.z, message.pose.pose.orientation);
  if (!pose) return tl::unexpected(pose.error());
  const double forward = message.twist.twist.linear.x;
  const double turn = message.twist.twist.angular.z;
  if (!std::isfinite(forward) || !std::isfinite(turn)) return common::invalid_input("a speed that is not finite");
  return common::RosOdometry{*std::move(header), frame_of(message.child_frame_id), *pose, forward, turn};
}

Result<common::RosImage> from_ros(const idl::Image& message) {
  return header_of(message.header).map([&](common::RosHeader&& header) {
    return common::RosImage{std::move(header), message.height,       message.width, idl::text_of(message.encoding),
                            message.step,      span_of(message.data)};
  });
}

Result<common::RosCompressedImage> from_ros(const idl::CompressedImage& message) {
  return header_of(message.header).map([&](common::RosHeader&& header) {
    return common::RosCompressedImage{std::move(header), idl::text_of(message.format), span_of(message.data)};
  });
}

Result<common::RosCameraInfo> from_ros(const idl::CameraInfo& message) {
  return header_of(message.header).map([&](common::RosHeader&& header) {
    return common::RosCameraInfo{std::move(header),
                                 message.height,
                                 message.width,
                                 idl::text_of(message.distortion_model),
                                 list_of(span_of(message.d)),
                                 {std::begin(message.k), std::end(message.k)}};
  });
}

Result<std::vector<common::RosTransform>> from_ros(const idl::TFMessage& message) {
  std::vector<common::RosTransform> transforms;
  for (const idl::TransformStamped& transform : span_of(message.transforms)) {
    auto header = header_of(transform.header);
    if (!header) return tl::unexpected(header.error());
    const auto& position = transform.transform.translation;
    const auto pose = pose_of(position.x, position.y, position.z, transform.transform.rotation);
    if (!pose) return tl::unexpected(pose.error());
    transforms.push_back({*std::move(header), frame_of(transform.child_frame_id), *pose});
  }
  return transforms;
}

Result<RosPose> from_ros(const idl::PoseWithCovarianceStamped& message) {
  return pose_of(message.header, nullptr, message.pose.pose, &message.pose.covariance);
}

Result<RosPose> from_ros(const idl::PoseStamped& message) {
  return pose_of(message.header, nullptr, message.pose, nullptr);
}

Result<RosPose> pose_from_ros(const idl::Odometry& message) {
  return pose_of(message.header, message.child_frame_id, message.pose.pose, &message.pose.covariance);
}

}  // namespace slamfuse::service
