// SPDX-License-Identifier: BSD-3-Clause
#include "common/wire_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/recording_samples.hpp"
#include "common/ros_bag_samples.hpp"
#include "common/ros_messages.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::span<const std::uint8_t> view(const std::string& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

RosEncoding encoding_of(Wire wire) { return wire == Wire::kRos1 ? RosEncoding::kRos1 : RosEncoding::kCdr; }

/// Every serialisation there is.
class EveryWire : public testing::TestWithParam<Wire> {};
INSTANTIATE_TEST_SUITE_P(Wires, EveryWire, testing::Values(Wire::kRos1, Wire::kCdr, Wire::kBigEndianCdr));

TEST_P(EveryWire, CarriesAScan) {
  SampleScan sample;
  sample.stamp = kSampleStart + 5;
  sample.frame = "a_frame_of_odd_length";
  sample.time_increment = 0.25F;
  const auto scan = decode_laser_scan(encoding_of(GetParam()), view(scan_message(GetParam(), sample)));
  ASSERT_TRUE(scan) << scan.error().message;
  EXPECT_EQ(scan->header.stamp, kSampleStart + 5);
  EXPECT_EQ(scan->header.frame, "a_frame_of_odd_length");
  EXPECT_EQ(scan->angle_min, -1.5F);
  EXPECT_EQ(scan->angle_increment, 1.0F);
  EXPECT_EQ(scan->time_increment, 0.25F);
  EXPECT_EQ(scan->range_max, 10.0F);
  EXPECT_THAT(scan->ranges, ElementsAre(1.0F, 2.0F, 3.0F, 4.0F));
}

TEST_P(EveryWire, CarriesOdometry) {
  const std::string bytes = odometry_message(GetParam(), kSampleStart, "/base", planar(1.0, -2.0, 0.5), 0.25, -0.125);
  const auto odometry = decode_odometry(encoding_of(GetParam()), view(bytes));
  ASSERT_TRUE(odometry) << odometry.error().message;
  EXPECT_EQ(odometry->child_frame, "base") << "frames without the leading slash of ROS 1";
  EXPECT_NEAR(to_pose2(odometry->pose).theta, 0.5, 1e-12);
  EXPECT_EQ(odometry->pose.translation.y(), -2.0);
  EXPECT_EQ(odometry->forward_speed, 0.25);
  EXPECT_EQ(odometry->turn_rate, -0.125);
}

TEST_P(EveryWire, CarriesTransforms) {
  const std::string bytes = transforms_message(
      GetParam(), kSampleStart, {{"odom", "base_link", planar(1, 2, 3)}, {"base_link", "laser", planar(0.1, 0, 0)}});
  const auto transforms = decode_transforms(encoding_of(GetParam()), view(bytes));
  ASSERT_TRUE(transforms) << transforms.error().message;
  ASSERT_EQ(transforms->size(), 2U);
  EXPECT_EQ(transforms->back().header.frame, "base_link");
  EXPECT_EQ(transforms->back().child_frame, "laser");
  EXPECT_EQ(transforms->back().pose.translation.x(), 0.1);
}

TEST_P(EveryWire, CarriesImagesAndTheirCalibration) {
  const auto image =
      decode_image(encoding_of(GetParam()), view(image_message(GetParam(), kSampleStart, "mono8", 3, 2, "abcdef")));
  ASSERT_TRUE(image) << image.error().message;
  EXPECT_EQ(image->width, 3U);
  EXPECT_EQ(image->height, 2U);
  EXPECT_EQ(image->step, 3U);
  EXPECT_EQ(image->encoding, "mono8");
  const auto info = decode_camera_info(encoding_of(GetParam()), view(camera_info_message(GetParam(), 640, 480, 500.0)));
  ASSERT_TRUE(info) << info.error().message;
  EXPECT_EQ(info->width, 640U);
  EXPECT_EQ(info->distortion_model, "plumb_bob");
  EXPECT_THAT(info->d, ElementsAre(-0.1, 0.02, 0.001, -0.002, 0.0));
  EXPECT_THAT(info->k, ElementsAre(500, 0, 320, 0, 500, 240, 0, 0, 1));
}

TEST_P(EveryWire, RefusesEveryCut) {
  const std::string scan = scan_message(GetParam(), {});
  // The intensities behind the ranges are not looked at: four bytes of length.
  for (std::size_t size = 0; size + 4 < scan.size(); ++size) {
    const auto cut = decode_laser_scan(encoding_of(GetParam()), view(scan.substr(0, size)));
    ASSERT_FALSE(cut) << size << " bytes of " << scan.size();
    EXPECT_GT(cut.error().message.size(), 10U);
  }
  const std::string odometry = odometry_message(GetParam(), kSampleStart, "base", planar(0, 0, 0));
  for (std::size_t size = 0; size + 36 * sizeof(double) < odometry.size(); ++size) {
    ASSERT_FALSE(decode_odometry(encoding_of(GetParam()), view(odometry.substr(0, size))));
  }
}

TEST_P(EveryWire, RefusesAHugeLengthBeforeItTakesMemory) {
  WireWriter writer(GetParam());
  writer.number(std::uint32_t{0xFFFFFFFF});
  const auto transforms = decode_transforms(encoding_of(GetParam()), view(writer.bytes()));
  ASSERT_FALSE(transforms);
  EXPECT_THAT(transforms.error().message, HasSubstr("4294967295 items"));

  WireWriter scan(GetParam());
  scan.header(kSampleStart, "laser");
  for (int i = 0; i < 7; ++i) scan.number(1.0F);
  scan.number(std::uint32_t{0x40000000});
  EXPECT_FALSE(decode_laser_scan(encoding_of(GetParam()), view(scan.bytes())));
}

TEST_P(EveryWire, RefusesStampsThatAreNoTime) {
  WireWriter writer(GetParam());
  if (GetParam() == Wire::kRos1) writer.number(std::uint32_t{0});
  writer.number(std::uint32_t{5}).number(std::uint32_t{1'000'000'000}).text("frame");
  const auto header = decode_header(encoding_of(GetParam()), view(writer.bytes()));
  ASSERT_FALSE(header);
  EXPECT_THAT(header.error().message, HasSubstr("stamp 5 s 1000000000 ns"));
}

TEST_P(EveryWire, RefusesPosesThatAreNone) {
  Pose3 no_rotation;
  no_rotation.rotation.coeffs().setZero();
  EXPECT_FALSE(decode_pose_stamped(encoding_of(GetParam()), view(pose_message(GetParam(), 1, no_rotation))));
  Pose3 not_finite;
  not_finite.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(decode_pose_stamped(encoding_of(GetParam()), view(pose_message(GetParam(), 1, not_finite))));
}

TEST(CdrReader, RefusesOtherEncapsulations) {
  for (const char kind : {'\2', '\3', '\6', '\7', '\xB'}) {
    std::string bytes = scan_message(Wire::kCdr, {});
    bytes[1] = kind;
    const auto scan = decode_laser_scan(RosEncoding::kCdr, view(bytes));
    ASSERT_FALSE(scan);
    EXPECT_THAT(scan.error().message, HasSubstr("encapsulation 0x00"));
  }
}

}  // namespace
}  // namespace slamfuse::common
