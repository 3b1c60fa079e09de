// SPDX-License-Identifier: BSD-3-Clause
// What is published, read back as serve reads it.
#include "service/sensor_to_ros.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/ros_conversions.hpp"
#include "service/ros_to_sensor.hpp"

namespace slamfuse::service {
namespace {

constexpr common::Nanoseconds kStamp = 1'700'000'000'123'456'789;
const RosHeader kHeader{kStamp, "laser0"};

TEST(SensorToRos, AScanComesBack) {
  common::LaserCalibration laser;
  laser.angle_min = -1.5;
  laser.angle_increment = 1.0;
  laser.beams = 4;
  laser.range_min = 0.1;
  laser.range_max = 5.0;
  laser.sweep_duration = 0.06;
  const common::LaserScan scan{kStamp, "laser0", {1.5F, std::numeric_limits<float>::infinity(), std::nanf(""), 4.0F}};
  const auto read = from_ros(*to_ros_scan(kHeader, scan, laser));
  ASSERT_TRUE(read);
  const auto geometry = common::laser_calibration_of(*read, {});
  ASSERT_TRUE(geometry);
  EXPECT_EQ(geometry->beams, 4);
  EXPECT_NEAR(geometry->sweep_duration, 0.06, 1e-6);
  const auto back = common::to_laser_scan(*read, "laser0", *geometry);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->stamp, kStamp);
  EXPECT_EQ(back->ranges[0], 1.5F);
  EXPECT_EQ(back->ranges[1], std::numeric_limits<float>::infinity());
  EXPECT_TRUE(std::isnan(back->ranges[2]));
}

TEST(SensorToRos, APictureAndItsCameraComeBack) {
  common::CameraCalibration camera;
  camera.width = 3;
  camera.height = 2;
  camera.fx = 500.0;
  camera.fy = 501.0;
  camera.cx = 1.0;
  camera.cy = 0.5;
  camera.k1 = -0.1;
  camera.k3 = 0.01;
  const auto info = from_ros(*to_ros_camera_info(kHeader, camera));
  ASSERT_TRUE(info);
  const auto back = common::camera_calibration_of(*info, {});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->fy, 501.0);
  EXPECT_EQ(back->k1, -0.1);
  EXPECT_EQ(back->k3, 0.01);

  const std::vector<std::uint8_t> pixels{0, 1, 2, 253, 254, 255};
  const common::Image image{kStamp, "cam0", 3, 2, std::make_shared<const std::vector<std::uint8_t>>(pixels)};
  const auto message = to_ros_image(kHeader, image);
  const auto read = from_ros(*message);
  ASSERT_TRUE(read);
  const auto gray = common::to_gray(*read, {3, 2});
  ASSERT_TRUE(gray);
  EXPECT_EQ(*gray->pixels, pixels);
}

TEST(SensorToRos, OdometryAndMountingsComeBack) {
  const auto odometry =
      from_ros(*to_ros_odometry({kStamp, "odom"}, "base_link", {kStamp, "odom0", {1, 2, 3}, 0.5, -0.2}));
  ASSERT_TRUE(odometry);
  EXPECT_EQ(odometry->child_frame, "base_link");
  EXPECT_NEAR(common::to_pose2(odometry->pose).theta, 3.0, 1e-12);
  EXPECT_EQ(odometry->turn_rate, -0.2);
  const auto transforms = from_ros(*to_ros_transforms(
      {kStamp, "base_link"}, {{"a", common::to_pose3({1, 0, 0})}, {"b", common::to_pose3({2, 0, 0})}}));
  ASSERT_TRUE(transforms);
  ASSERT_EQ(transforms->size(), 2u);
  EXPECT_EQ((*transforms)[1].child_frame, "b");
  EXPECT_EQ((*transforms)[1].pose.translation.x(), 2.0);
}

TEST(RosToSensor, RefusesWhatIsNoTimeOrNoPose) {
  idl::Message<idl::LaserScan> scan;
  scan->header.stamp = {5, 1'000'000'000};
  EXPECT_FALSE(from_ros(*scan));
  scan->header.stamp = {-5, 0};
  EXPECT_FALSE(from_ros(*scan));
  idl::Message<idl::Odometry> odometry;  // a quaternion of zeros
  EXPECT_FALSE(from_ros(*odometry));
  odometry->pose.pose.orientation.w = 1.0;
  EXPECT_TRUE(from_ros(*odometry));
  odometry->twist.twist.linear.x = std::nan("");
  EXPECT_FALSE(from_ros(*odometry));
}

// Found by fuzzing: rows were divided by.
TEST(ToGray, RefusesAnImageWithoutPixels) {
  common::RosImage image;
  image.encoding = "mono8";
  EXPECT_FALSE(common::to_gray(image, {0, 0}));
}

}  // namespace
}  // namespace slamfuse::service
