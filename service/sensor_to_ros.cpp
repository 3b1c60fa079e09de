// SPDX-License-Identifier: BSD-3-Clause
#include "service/sensor_to_ros.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace slamfuse::service {
namespace {

void set_header(idl::Header& target, const RosHeader& header) {
  target.stamp = to_ros_time(header.stamp);
  idl::assign(target.frame_id, header.frame);
}

idl::Quaternion to_ros(const Eigen::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

template <class Sequence, class Values>
void fill(Sequence& sequence, const Values& values) {
  idl::allocate(sequence, values.size());
  std::copy(values.begin(), values.end(), sequence._buffer);
}

}  // namespace

idl::Message<idl::LaserScan> to_ros_scan(const RosHeader& header, const common::LaserScan& scan,
                                         const common::LaserCalibration& laser) {
  const std::size_t steps = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  idl::Message<idl::LaserScan> message;
  set_header(message->header, header);
  message->angle_min = static_cast<float>(laser.angle_min);
  message->angle_max = static_cast<float>(laser.angle_min + static_cast<double>(steps) * laser.angle_increment);
  message->angle_increment = static_cast<float>(laser.angle_increment);
  if (steps > 0) message->time_increment = static_cast<float>(laser.sweep_duration / static_cast<double>(steps));
  message->range_min = static_cast<float>(laser.range_min);
  message->range_max = static_cast<float>(laser.range_max);
  fill(message->ranges, scan.ranges);
  return message;
}

idl::Message<idl::Image> to_ros_image(const RosHeader& header, const common::Image& image) {
  idl::Message<idl::Image> message;
  set_header(message->header, header);
  message->height = static_cast<std::uint32_t>(image.height);
  message->width = static_cast<std::uint32_t>(image.width);
  idl::assign(message->encoding, "mono8");
  message->step = message->width;
  fill(message->data, *image.pixels);
  return message;
}

idl::Message<idl::CameraInfo> to_ros_camera_info(const RosHeader& header, const common::CameraCalibration& camera) {
  idl::Message<idl::CameraInfo> message;
  set_header(message->header, header);
  message->height = static_cast<std::uint32_t>(camera.height);
  message->width = static_cast<std::uint32_t>(camera.width);
  idl::assign(message->distortion_model, "plumb_bob");
  fill(message->d, std::array{camera.k1, camera.k2, camera.p1, camera.p2, camera.k3});
  const std::array<double, 9> k{camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  std::ranges::copy(k, message->k);
  const std::array<double, 9> r{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  std::ranges::copy(r, message->r);
  const std::array<double, 12> p{camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  std::ranges::copy(p, message->p);
  return message;
}

idl::Message<idl::Odometry> to_ros_odometry(const RosHeader& header, const std::string& base_frame,
                                            const common::WheelOdometry& odometry) {
  idl::Message<idl::Odometry> message;
  set_header(message->header, header);
  idl::assign(message->child_frame_id, base_frame);
  message->pose.pose = {{odometry.pose.x, odometry.pose.y, 0.0}, yaw_to_quaternion(odometry.pose.theta)};
  message->twist.twist.linear.x = odometry.forward_speed;
  message->twist.twist.angular.z = odometry.turn_rate;
  return message;
}

idl::Message<idl::Imu> to_ros_imu(const RosHeader& header, const common::Imu& imu) {
  idl::Message<idl::Imu> message;
  set_header(message->header, header);
  message->orientation.w = 1.0;
  message->orientation_covariance[0] = -1.0;  // sensor_msgs/Imu: there is no orientation
  const auto& turn = imu.angular_velocity;
  const auto& force = imu.linear_acceleration;
  message->angular_velocity = {turn.x(), turn.y(), turn.z()};
  message->linear_acceleration = {force.x(), force.y(), force.z()};
  return message;
}

idl::Message<idl::TFMessage> to_ros_transforms(const RosHeader& header, const std::vector<ChildFrame>& children) {
  idl::Message<idl::TFMessage> message;
  idl::allocate(message->transforms, children.size());
  for (std::size_t i = 0; i < children.size(); ++i) {
    idl::TransformStamped& transform = message->transforms._buffer[i];
    set_header(transform.header, header);
    idl::assign(transform.child_frame_id, children[i].name);
    const common::Pose3& pose = children[i].T_parent_child;
    transform.transform = {{pose.translation.x(), pose.translation.y(), pose.translation.z()}, to_ros(pose.rotation)};
  }
  return message;
}

}  // namespace slamfuse::service
