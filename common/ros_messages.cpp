// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_messages.hpp"

#include <array>
#include <cmath>

namespace slamfuse::common {
namespace {

constexpr std::size_t kCovarianceNumbers = 36;
constexpr std::size_t kMatrixNumbers = 9;
/// A transform takes at least a stamp, two texts and seven numbers.
constexpr std::size_t kSmallestTransform = 8 + 4 + 4 + 7 * sizeof(double);

template <class Number>
std::vector<Number> read_list(auto& reader) {
  std::vector<Number> list(reader.list_length(sizeof(Number)));
  for (Number& item : list) item = reader.template number<Number>();
  return list;
}

/// A position and a quaternion x, y, z, w; not checked.
Pose3 read_pose(auto& reader) {
  Pose3 pose;
  for (int i = 0; i < 3; ++i) pose.translation[i] = reader.template number<double>();
  for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = reader.template number<double>();
  return pose;
}

/// What `read` makes of the reader for this encoding; the reader's problem, if there was one, becomes an error.
template <class Message>
Result<Message> decode(RosEncoding encoding, std::span<const std::uint8_t> bytes, const auto& read) {
  const auto finish = [&read](auto reader) -> Result<Message> {
    Message message = read(reader);
    if (!reader.problem().empty()) return invalid_input(reader.problem());
    return message;
  };
  return encoding == RosEncoding::kCdr ? finish(CdrReader(bytes)) : finish(Ros1Reader(bytes));
}

}  // namespace

Result<void> normalise(Pose3& pose) {
  const double norm = pose.rotation.norm();
  if (!pose.is_finite() || !(norm > 0.5 && norm < 2.0)) {
    return invalid_input("a pose that is not finite, or whose quaternion is not of unit length");
  }
  pose.rotation.coeffs() /= norm;
  return {};
}

Result<RosLaserScan> decode_laser_scan(RosEncoding encoding, std::span<const std::uint8_t> message) {
  return decode<RosLaserScan>(encoding, message, [](auto& reader) {
    RosLaserScan scan;
    scan.header = reader.header();
    scan.angle_min = reader.template number<float>();
    scan.angle_max = reader.template number<float>();
    scan.angle_increment = reader.template number<float>();
    scan.time_increment = reader.template number<float>();
    reader.template number<float>();  // time between scans
    scan.range_min = reader.template number<float>();
    scan.range_max = reader.template number<float>();
    scan.ranges = read_list<float>(reader);
    return scan;
  });
}

Result<RosOdometry> decode_odometry(RosEncoding encoding, std::span<const std::uint8_t> message) {
  auto odometry = decode<RosOdometry>(encoding, message, [](auto& reader) {
    RosOdometry read;
    read.header = reader.header();
    read.child_frame = plain_frame(reader.text());
    read.pose = read_pose(reader);
    for (std::size_t i = 0; i < kCovarianceNumbers; ++i) reader.template number<double>();
    std::array<double, 6> twist{};  // linear x, y, z, angular x, y, z
    for (double& speed : twist) speed = reader.template number<double>();
    read.forward_speed = twist.front();
    read.turn_rate = twist.back();
    return read;
  });
  if (!odometry) return odometry;
  if (const auto good = normalise(odometry->pose); !good) return tl::unexpected(good.error());
  if (!(std::isfinite(odometry->forward_speed) && std::isfinite(odometry->turn_rate))) {
    return invalid_input("a speed that is not finite");
  }
  return odometry;
}

Result<RosPoseStamped> decode_pose_stamped(RosEncoding encoding, std::span<const std::uint8_t> message) {
  auto pose = decode<RosPoseStamped>(encoding, message, [](auto& reader) {
    const RosHeader header = reader.header();
    return RosPoseStamped{header, read_pose(reader)};
  });
  if (!pose) return pose;
  if (const auto good = normalise(pose->pose); !good) return tl::unexpected(good.error());
  return pose;
}

Result<std::vector<RosTransform>> decode_transforms(RosEncoding encoding, std::span<const std::uint8_t> message) {
  auto transforms = decode<std::vector<RosTransform>>(encoding, message, [](auto& reader) {
    std::vector<RosTransform> read(reader.list_length(kSmallestTransform));
    for (RosTransform& transform : read) {
      transform.header = reader.header();
      transform.child_frame = plain_frame(reader.text());
      transform.pose = read_pose(reader);
    }
    return read;
  });
  if (!transforms) return transforms;
  for (RosTransform& transform : *transforms) {
    if (const auto good = normalise(transform.pose); !good) return tl::unexpected(good.error());
  }
  return transforms;
}

Result<RosImage> decode_image(RosEncoding encoding, std::span<const std::uint8_t> message) {
  return decode<RosImage>(encoding, message, [](auto& reader) {
    RosImage image;
    image.header = reader.header();
    image.height = reader.template number<std::uint32_t>();
    image.width = reader.template number<std::uint32_t>();
    image.encoding = reader.text();
    reader.template number<std::uint8_t>();  // byte order, of no meaning with one byte a channel
    image.step = reader.template number<std::uint32_t>();
    image.data = reader.take(reader.list_length(1));
    return image;
  });
}

Result<RosCompressedImage> decode_compressed_image(RosEncoding encoding, std::span<const std::uint8_t> message) {
  return decode<RosCompressedImage>(encoding, message, [](auto& reader) {
    RosCompressedImage image;
    image.header = reader.header();
    image.format = reader.text();
    image.data = reader.take(reader.list_length(1));
    return image;
  });
}

Result<RosCameraInfo> decode_camera_info(RosEncoding encoding, std::span<const std::uint8_t> message) {
  return decode<RosCameraInfo>(encoding, message, [](auto& reader) {
    RosCameraInfo info;
    info.header = reader.header();
    info.height = reader.template number<std::uint32_t>();
    info.width = reader.template number<std::uint32_t>();
    info.distortion_model = reader.text();
    info.d = read_list<double>(reader);
    info.k.resize(kMatrixNumbers);
    for (double& number : info.k) number = reader.template number<double>();
    return info;
  });
}

Result<RosHeader> decode_header(RosEncoding encoding, std::span<const std::uint8_t> message) {
  return decode<RosHeader>(encoding, message, [](auto& reader) { return reader.header(); });
}

}  // namespace slamfuse::common
