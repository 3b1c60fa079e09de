// SPDX-License-Identifier: BSD-3-Clause
// What a stranger may send to `serve`: CDR as Cyclone takes it off the wire, decoded with the generated descriptors,
// then checked and used as LiveSource does. The first byte chooses the type.
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>
#include <dds/ddsi/ddsi_serdata_default.h>

#include "common/ros_conversions.hpp"
#include "idl/message.hpp"
#include "service/operator_services.hpp"
#include "service/ros_to_sensor.hpp"
#include "service/sensor_discovery.hpp"

namespace {

using namespace slamfuse;

/// What Cyclone's reader needs of a type, without a participant.
template <class T>
const ddsi_sertype_default& sertype() {
  static const ddsi_sertype_default kType = [] {
    ddsi_sertype_default type{};
    const dds_topic_descriptor_t& descriptor = idl::descriptor<T>();
    type.type.size = descriptor.m_size;
    type.type.align = descriptor.m_align;
    type.type.flagset = descriptor.m_flagset;
    type.type.ops.ops = const_cast<std::uint32_t*>(descriptor.m_ops);
    type.type.ops.nops = dds_stream_countops(descriptor.m_ops, descriptor.m_nkeys, descriptor.m_keys);
    type.opt_size_xcdr1 = dds_stream_check_optimize(&type.type, 1);
    return type;
  }();
  return kType;
}

/// Hands the message on to `use` if Cyclone would deliver it.
template <class T, class Use>
void decode(const std::uint8_t* data, std::size_t size, const Use& use) {
  std::vector<std::uint8_t> bytes(data, data + size);
  bytes.resize(size + 8);  // it may look a word ahead
  std::uint32_t actual = 0;
  constexpr std::uint32_t kXcdr1 = 1;
  if (!dds_stream_normalize(bytes.data(), static_cast<std::uint32_t>(size), false, kXcdr1, &sertype<T>(), false,
                            &actual))
    return;
  idl::Message<T> message;
  dds_istream_t stream;
  dds_istream_init(&stream, actual, bytes.data(), kXcdr1);
  dds_stream_read_sample(&stream, &*message, &sertype<T>());
  use(*message);
}

void use_scan(const idl::LaserScan& message) {
  service::SensorDiscovery discovery("base_link");
  discovery.hear("laser0", message);
  if (!discovery.usable("laser0")) return;
  common::RecordingInfo info;
  discovery.describe(info);
  const auto scan = service::from_ros(message);
  if (scan) static_cast<void>(common::to_laser_scan(*scan, "laser0", info.calibration.lasers.at("laser0")));
}

void use_camera(const idl::CameraInfo& message) {
  service::SensorDiscovery discovery("base_link");
  discovery.hear("cam0", message);
  discovery.hear("cam0", idl::Image{});
  if (!discovery.usable("cam0")) return;
  common::RecordingInfo info;
  discovery.describe(info);
}

void use_transforms(const idl::TFMessage& message) {
  service::SensorDiscovery discovery("base_link");
  discovery.hear("", message);
  common::RecordingInfo info;
  discovery.describe(info);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0 || size > (std::size_t{1} << 20)) return 0;
  const int type = *data++ % 8;
  --size;
  constexpr common::ImageSize kSize{64, 48};
  switch (type) {
    case 0:
      decode<idl::LaserScan>(data, size, use_scan);
      break;
    case 1:
      decode<idl::Odometry>(data, size, [](const auto& message) {
        if (const auto odometry = service::from_ros(message)) common::to_wheel_odometry(*odometry, "odom0", {});
        static_cast<void>(service::pose_from_ros(message));
      });
      break;
    case 2:
      decode<idl::Image>(data, size, [&](const auto& message) {
        if (const auto image = service::from_ros(message)) static_cast<void>(common::to_gray(*image, kSize));
      });
      break;
    case 3:
      decode<idl::CompressedImage>(data, size,
                                   [](const auto& message) { static_cast<void>(service::from_ros(message)); });
      break;
    case 4:
      decode<idl::CameraInfo>(data, size, use_camera);
      break;
    case 5:
      decode<idl::TFMessage>(data, size, use_transforms);
      break;
    case 6:
      decode<idl::PoseWithCovarianceStamped>(
          data, size, [](const auto& message) { static_cast<void>(service::set_pose_of(message)); });
      break;
    default:
      decode<idl::PoseStamped>(data, size, [](const auto& message) { static_cast<void>(service::from_ros(message)); });
  }
  return 0;
}
