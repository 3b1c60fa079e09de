// SPDX-License-Identifier: BSD-3-Clause
// One serialised ROS message. The first byte chooses type and encoding.
#include "common/image_decoder.hpp"
#include "common/ros_conversions.hpp"
#include "common/ros_messages.hpp"

namespace {

using namespace slamfuse::common;

void read(int type, RosEncoding encoding, std::span<const std::uint8_t> bytes) {
  constexpr ImageSize kSize{64, 48};
  switch (type) {
    case 0:
      if (const auto scan = decode_laser_scan(encoding, bytes)) {
        const auto laser = laser_calibration_of(*scan, {});
        if (laser) static_cast<void>(to_laser_scan(*scan, "laser0", *laser));
      }
      return;
    case 1:
      if (const auto odometry = decode_odometry(encoding, bytes)) to_wheel_odometry(*odometry, "odom0", {});
      return;
    case 2:
      static_cast<void>(decode_transforms(encoding, bytes));
      return;
    case 3:
      if (const auto image = decode_image(encoding, bytes)) {
        static_cast<void>(to_gray(*image, kSize));
        static_cast<void>(
            to_gray(*image, {static_cast<int>(image->width & 0xfff), static_cast<int>(image->height & 0xfff)}));
      }
      return;
    case 4:
      if (const auto image = decode_compressed_image(encoding, bytes)) {
        static_cast<void>(decode_gray_image(image->data, kSize));
      }
      return;
    case 5:
      if (const auto info = decode_camera_info(encoding, bytes)) static_cast<void>(camera_calibration_of(*info, {}));
      return;
    case 6:
      static_cast<void>(decode_pose_stamped(encoding, bytes));
      return;
    default:
      static_cast<void>(decode_header(encoding, bytes));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  constexpr int kTypes = 8;
  const auto encoding = (*data & 0x80) != 0 ? RosEncoding::kRos1 : RosEncoding::kCdr;
  read(*data % kTypes, encoding, {data + 1, size - 1});
  return 0;
}
