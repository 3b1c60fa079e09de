// SPDX-License-Identifier: BSD-3-Clause
#include "service/ros_conversion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#include "common/angle.hpp"

namespace slamfuse::service {
namespace {

constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField.FLOAT32
constexpr std::array<const char*, 4> kCloudFields = {"x", "y", "z", "intensity"};

void set_header(idl::Header& target, const RosHeader& header) {
  target.stamp = to_ros_time(header.stamp);
  idl::assign(target.frame_id, header.frame);
}

idl::Pose to_ros(const common::Pose2& pose) { return {{pose.x, pose.y, 0.0}, yaw_to_quaternion(pose.theta)}; }

template <class Strings>
void set_texts(Strings& target, const std::vector<std::string>& texts) {
  idl::allocate(target, texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) idl::assign(target._buffer[i], texts[i]);
}

std::uint8_t to_ros(fusion::Verdict verdict) {
  switch (verdict) {
    case fusion::Verdict::kTracking:
      return 0;
    case fusion::Verdict::kSuspect:
      return 1;
    case fusion::Verdict::kLost:
      break;
  }
  return 2;
}

}  // namespace

idl::Time to_ros_time(common::Nanoseconds stamp) {
  common::Nanoseconds seconds = stamp / common::kNanosecondsPerSecond;
  common::Nanoseconds rest = stamp % common::kNanosecondsPerSecond;
  if (rest < 0) {
    --seconds;
    rest += common::kNanosecondsPerSecond;
  }
  using Seconds = std::numeric_limits<std::int32_t>;
  return {static_cast<std::int32_t>(std::clamp<common::Nanoseconds>(seconds, Seconds::min(), Seconds::max())),
          static_cast<std::uint32_t>(rest)};
}

common::Nanoseconds from_ros_time(const idl::Time& time) {
  return time.sec * common::kNanosecondsPerSecond + time.nanosec;
}

idl::Quaternion yaw_to_quaternion(double yaw) { return {0.0, 0.0, std::sin(yaw / 2.0), std::cos(yaw / 2.0)}; }

double quaternion_to_yaw(const idl::Quaternion& q) {
  return common::normalize_angle(std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)));
}

std::array<double, 36> to_ros_covariance(const Eigen::Matrix3d& covariance) {
  constexpr std::array<std::size_t, 3> kPlace = {0, 1, 5};  // of x, y, yaw among the six
  std::array<double, 36> wide{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      wide[6 * kPlace[row] + kPlace[column]] = covariance(static_cast<int>(row), static_cast<int>(column));
    }
  }
  return wide;
}

idl::Message<idl::PoseWithCovarianceStamped> to_ros_pose(const RosHeader& header, const common::Pose2& pose,
                                                         const Eigen::Matrix3d& covariance) {
  idl::Message<idl::PoseWithCovarianceStamped> message;
  set_header(message->header, header);
  message->pose.pose = to_ros(pose);
  std::ranges::copy(to_ros_covariance(covariance), message->pose.covariance);
  return message;
}

idl::Message<idl::TFMessage> to_ros_transform(const RosHeader& header, const std::string& child,
                                              const common::Pose2& pose) {
  idl::Message<idl::TFMessage> message;
  idl::allocate(message->transforms, 1);
  idl::TransformStamped& transform = message->transforms._buffer[0];
  set_header(transform.header, header);
  idl::assign(transform.child_frame_id, child);
  transform.transform = {{pose.x, pose.y, 0.0}, yaw_to_quaternion(pose.theta)};
  return message;
}

idl::Message<idl::OccupancyGrid> to_ros_grid(const RosHeader& header, const common::OccupancyGrid& grid) {
  idl::Message<idl::OccupancyGrid> message;
  set_header(message->header, header);
  message->info.map_load_time = message->header.stamp;
  message->info.resolution = static_cast<float>(grid.resolution);
  message->info.width = static_cast<std::uint32_t>(grid.width);
  message->info.height = static_cast<std::uint32_t>(grid.height);
  message->info.origin = to_ros({grid.origin.x(), grid.origin.y(), 0.0});
  idl::allocate(message->data, grid.cells.size());
  std::ranges::copy(grid.cells, message->data._buffer);
  return message;
}

idl::Message<idl::Path> to_ros_path(const RosHeader& header, const common::Trajectory2& path, std::size_t max_poses) {
  const std::size_t count = std::min(path.size(), max_poses);
  idl::Message<idl::Path> message;
  set_header(message->header, header);
  idl::allocate(message->poses, count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& stamped = path[count == 1 ? 0 : i * (path.size() - 1) / (count - 1)];
    set_header(message->poses._buffer[i].header, {stamped.stamp, header.frame});
    message->poses._buffer[i].pose = to_ros(stamped.pose);
  }
  return message;
}

idl::Message<idl::PointCloud2> to_ros_cloud(const RosHeader& header, const std::vector<common::Landmark>& landmarks) {
  std::vector<float> values;
  for (const common::Landmark& landmark : landmarks) {
    if (!landmark.position.allFinite()) continue;
    for (const double coordinate : landmark.position) values.push_back(static_cast<float>(coordinate));
    values.push_back(static_cast<float>(landmark.gray));
  }
  idl::Message<idl::PointCloud2> message;
  set_header(message->header, header);
  idl::allocate(message->fields, kCloudFields.size());
  for (std::size_t i = 0; i < kCloudFields.size(); ++i) {
    idl::PointField& field = message->fields._buffer[i];
    idl::assign(field.name, kCloudFields[i]);
    field.offset = static_cast<std::uint32_t>(i * sizeof(float));
    field.datatype = kFloat32;
    field.count = 1;
  }
  message->height = 1;
  message->width = static_cast<std::uint32_t>(values.size() / kCloudFields.size());
  message->point_step = static_cast<std::uint32_t>(kCloudFields.size() * sizeof(float));
  message->row_step = message->point_step * message->width;
  message->is_dense = true;
  idl::allocate(message->data, values.size() * sizeof(float));
  if (!values.empty()) std::memcpy(message->data._buffer, values.data(), values.size() * sizeof(float));
  return message;
}

idl::Message<idl::FusionStatus> to_ros_status(const RosHeader& header, const std::vector<fusion::StatusEntry>& latest) {
  const auto is_fused = [](const auto& entry) { return entry.source == common::PoseSource::kFused; };
  idl::Message<idl::FusionStatus> message;
  set_header(message->header, header);
  message->state = to_ros(fusion::Verdict::kLost);  // until the fusion says otherwise
  idl::allocate(message->sources, latest.size() - static_cast<std::size_t>(std::ranges::count_if(latest, is_fused)));
  idl::SourceStatus* source = message->sources._buffer;
  for (const fusion::StatusEntry& entry : latest) {
    if (is_fused(entry)) {
      message->state = to_ros(entry.state);
      message->score = entry.score;
      set_texts(message->reasons, entry.reasons);
    } else {
      idl::assign(source->source, common::to_string(entry.source));
      source->state = to_ros(entry.state);
      source->score = entry.score;
      set_texts(source->reasons, entry.reasons);
      ++source;
    }
  }
  return message;
}

}  // namespace slamfuse::service
