// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_survey.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace slamfuse::common {
namespace {

void count_stamp(RosTopicSummary& summary, Nanoseconds stamp) {
  summary.first_stamp = summary.messages == 0 ? stamp : std::min(summary.first_stamp, stamp);
  summary.last_stamp = summary.messages == 0 ? stamp : std::max(summary.last_stamp, stamp);
  ++summary.messages;
}

class Surveyor {
 public:
  explicit Surveyor(const RosBag& bag) : encoding_(bag.encoding()) {
    for (const RosTopic& topic : bag.topics()) {
      RosTopicSummary summary;
      summary.topic = topic;
      summary.type = ros_type(topic.type);
      survey_.topics.push_back(std::move(summary));
    }
  }

  void add(const RosBagMessage& message) {
    RosTopicSummary& summary = survey_.topics[message.topic];
    if (summary.type == RosType::kOther) {
      ++summary.messages;
      return;
    }
    const Result<void> done = take_in(summary, message.data);
    if (done) return;
    if (summary.bad++ == 0) summary.first_problem = done.error().message;
  }

  RosSurvey result() && { return std::move(survey_); }

 private:
  Result<void> take_in(RosTopicSummary& summary, std::span<const std::uint8_t> data) {
    if (summary.type == RosType::kTransforms) return add_transforms(summary, data);
    const auto header = decode_header(encoding_, data);
    if (!header) return tl::unexpected(header.error());
    if (auto first = look_at_first(summary, data); !first) return first;
    if (summary.messages == 0) summary.frame = header->frame;
    count_stamp(summary, header->stamp);
    return {};
  }

  /// What the first good message of a topic tells beyond its head.
  Result<void> look_at_first(RosTopicSummary& summary, std::span<const std::uint8_t> data) {
    if (summary.messages > 0) return {};
    switch (summary.type) {
      case RosType::kLaserScan: {
        auto scan = decode_laser_scan(encoding_, data);
        if (!scan) return tl::unexpected(scan.error());
        summary.scan = std::move(*scan);
        return {};
      }
      case RosType::kOdometry: {
        const auto odometry = decode_odometry(encoding_, data);
        if (!odometry) return tl::unexpected(odometry.error());
        summary.child_frame = odometry->child_frame;
        return {};
      }
      case RosType::kImage: {
        const auto image = decode_image(encoding_, data);
        if (!image) return tl::unexpected(image.error());
        summary.encoding = image->encoding;
        return {};
      }
      case RosType::kCameraInfo: {
        auto camera = decode_camera_info(encoding_, data);
        if (!camera) return tl::unexpected(camera.error());
        summary.camera = std::move(*camera);
        return {};
      }
      case RosType::kCompressedImage:
      case RosType::kPoseStamped:
      case RosType::kTransforms:
      case RosType::kOther:
        return {};
    }
    return {};
  }

  Result<void> add_transforms(RosTopicSummary& summary, std::span<const std::uint8_t> data) {
    const auto transforms = decode_transforms(encoding_, data);
    if (!transforms) return tl::unexpected(transforms.error());
    ++summary.messages;
    const bool fixed = summary.topic.name.ends_with("tf_static");
    for (const RosTransform& transform : *transforms) {
      survey_.frames.add(transform.header.frame, transform.child_frame, transform.pose);
      if (fixed || transform.header.frame != kOdometryFrame) continue;
      count_stamp(survey_.moved_by_tf[transform.child_frame], transform.header.stamp);
    }
    return {};
  }

  RosEncoding encoding_;
  RosSurvey survey_;
};

}  // namespace

RosType ros_type(const std::string& type) {
  static const std::map<std::string, RosType> known{
      {"sensor_msgs/LaserScan", RosType::kLaserScan},   {"nav_msgs/Odometry", RosType::kOdometry},
      {"sensor_msgs/Image", RosType::kImage},           {"sensor_msgs/CompressedImage", RosType::kCompressedImage},
      {"sensor_msgs/CameraInfo", RosType::kCameraInfo}, {"geometry_msgs/PoseStamped", RosType::kPoseStamped},
      {"tf2_msgs/TFMessage", RosType::kTransforms},     {"tf/tfMessage", RosType::kTransforms}};
  const auto found = known.find(type);
  return found == known.end() ? RosType::kOther : found->second;
}

RosSurvey survey_ros_bag(RosBag& bag) {
  Surveyor surveyor(bag);
  std::set<std::size_t> all;
  for (std::size_t topic = 0; topic < bag.topics().size(); ++topic) all.insert(topic);
  bag.rewind(all);
  while (const auto item = bag.next()) {
    // Damage is told when the bag is played.
    if (const auto* message = std::get_if<RosBagMessage>(&*item)) surveyor.add(*message);
  }
  return std::move(surveyor).result();
}

}  // namespace slamfuse::common
