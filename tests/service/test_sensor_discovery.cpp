// SPDX-License-Identifier: BSD-3-Clause
#include "service/sensor_discovery.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "service/sensor_to_ros.hpp"
#include "service/three_beams.hpp"

namespace slamfuse::service {
namespace {

constexpr common::Nanoseconds kStamp = 1'700'000'000'000'000'000;

idl::Message<idl::LaserScan> scan(const std::string& frame) {
  return to_ros_scan({kStamp, frame}, {kStamp, "laser0", {1.0F, 2.0F, 3.0F}}, three_beams());
}

idl::Message<idl::CameraInfo> camera_info() {
  common::CameraCalibration camera;
  camera.width = 4;
  camera.height = 3;
  camera.fx = camera.fy = 2.0;
  return to_ros_camera_info({kStamp, "eye"}, camera);
}

idl::Message<idl::Image> image() {
  return to_ros_image({kStamp, "eye"},
                      {kStamp, "cam0", 4, 3, std::make_shared<const std::vector<std::uint8_t>>(12, 100)});
}

TEST(SensorDiscovery, KnowsTheKindOfASensorByItsName) {
  EXPECT_EQ(kind_of_sensor("laser1"), common::SensorKind::kLaser);
  EXPECT_EQ(kind_of_sensor("cam3"), common::SensorKind::kCamera);
  EXPECT_EQ(kind_of_sensor("odom0"), common::SensorKind::kOdometry);
  EXPECT_FALSE(kind_of_sensor("tf"));
}

TEST(SensorDiscovery, ALaserIsUsableAfterItsFirstScanAndStandsWhereTfSays) {
  SensorDiscovery discovery("base_link");
  EXPECT_FALSE(discovery.usable("laser0"));
  discovery.hear("laser0", *scan("front"));
  discovery.hear("tf", *to_ros_transforms({kStamp, "base_link"}, {{"front", common::to_pose3({0.2, 0.1, 0.5})}}));
  EXPECT_TRUE(discovery.usable("laser0"));
  EXPECT_EQ(discovery.newest_stamp(), kStamp);
  common::RecordingInfo info;
  discovery.describe(info);
  ASSERT_EQ(info.calibration.lasers.count("laser0"), 1u);
  EXPECT_EQ(info.calibration.lasers.at("laser0").beams, 3);
  EXPECT_NEAR(info.calibration.lasers.at("laser0").T_base_laser.translation.x(), 0.2, 1e-12);
  EXPECT_TRUE(info.notes.empty());
}

TEST(SensorDiscovery, ASensorWhoseMountingNobodyTellsIsAtTheRobotAndANoteSaysSo) {
  SensorDiscovery discovery("base_link");
  discovery.hear("cam0", *camera_info());
  discovery.hear("cam0", *image());
  common::RecordingInfo info;
  discovery.describe(info);
  ASSERT_EQ(info.notes.size(), 1u);
  EXPECT_NE(info.notes[0].find("eye"), std::string::npos);
  EXPECT_NE(info.notes[0].find("looking forward"), std::string::npos);
  const common::Pose3& mounting = info.calibration.cameras.at("cam0").T_base_camera;
  EXPECT_NEAR((mounting.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX()).norm(), 0.0, 1e-12);
}

TEST(SensorDiscovery, ACameraNeedsCalibrationAndAPicture) {
  SensorDiscovery discovery("base_link");
  EXPECT_EQ(discovery.problem_of("cam0"), "");
  discovery.hear("cam0", *image());
  EXPECT_FALSE(discovery.usable("cam0"));
  EXPECT_EQ(discovery.problem_of("cam0"), "no camera_info was heard of it");
  discovery.hear("cam1", *camera_info());
  EXPECT_EQ(discovery.problem_of("cam1"), "no picture was heard of it");
  discovery.hear("cam0", *camera_info());
  EXPECT_TRUE(discovery.usable("cam0"));
  EXPECT_EQ(discovery.usable_sensors(), std::set<std::string>{"cam0"});
  EXPECT_EQ(discovery.camera_info("cam0").width, 4);
}

TEST(SensorDiscovery, ACalibrationMayBeReplacedByAnother) {
  SensorDiscovery discovery("base_link");
  discovery.hear("cam0", *camera_info());
  discovery.hear("cam0", *image());
  auto other = discovery.camera_info("cam0");
  other.k[0] = 3.0;
  discovery.replace("cam0", other);
  common::RecordingInfo info;
  discovery.describe(info);
  EXPECT_EQ(info.calibration.cameras.at("cam0").fx, 3.0);
}

TEST(SensorDiscovery, FramesThatNoRobotHasDoNotFillTheMemory) {
  SensorDiscovery discovery("base_link");
  discovery.hear("laser0", *scan("front"));
  for (int i = 0; i < 3000; ++i) {
    discovery.hear("tf", *to_ros_transforms({kStamp, "base_link"}, {{"made_up_" + std::to_string(i), {}}}));
  }
  discovery.hear("tf", *to_ros_transforms({kStamp, "base_link"}, {{"front", common::to_pose3({0.2, 0.0, 0.0})}}));
  common::RecordingInfo info;
  discovery.describe(info);
  EXPECT_EQ(info.notes.size(), 1U) << "the one that came after all room was taken is not known";
}

TEST(SensorDiscovery, WhatCannotBeUsedLeavesAProblemUntilSomethingBetterComes) {
  SensorDiscovery discovery("base_link");
  auto bad = scan("front");
  bad->angle_increment = std::numeric_limits<float>::quiet_NaN();
  discovery.hear("laser0", *bad);
  EXPECT_FALSE(discovery.usable("laser0"));
  EXPECT_FALSE(discovery.problem_of("laser0").empty());
  discovery.hear("laser0", *scan("front"));
  EXPECT_TRUE(discovery.usable("laser0"));
  EXPECT_TRUE(discovery.problem_of("laser0").empty());
}

TEST(SensorDiscovery, OdometryOfAnotherFrameIsBroughtToTheBase) {
  SensorDiscovery discovery("base_link");
  discovery.hear("odom0", *to_ros_odometry({kStamp, "odom"}, "wheels", {kStamp, "odom0", {}, 0.0, 0.0}));
  EXPECT_EQ(discovery.unmounted(), std::set<std::string>{"odom0"});
  discovery.hear("tf", *to_ros_transforms({kStamp, "base_link"}, {{"wheels", common::to_pose3({0.3, 0.0, 0.0})}}));
  EXPECT_TRUE(discovery.unmounted().empty());
  EXPECT_NEAR(discovery.T_child_base("odom0").x, -0.3, 1e-12);
}

TEST(SensorDiscovery, WhereASensorWasAssumedToBeItStaysAndAProblemSaysSo) {
  SensorDiscovery discovery("base_link");
  discovery.hear("laser0", *scan("front"));
  discovery.hear("odom0", *to_ros_odometry({kStamp, "odom"}, "wheels", {kStamp, "odom0", {}, 0.0, 0.0}));
  EXPECT_EQ(discovery.unmounted().size(), 2U);
  common::RecordingInfo assumed;
  discovery.describe(assumed);
  EXPECT_EQ(assumed.notes.size(), 2U);
  EXPECT_TRUE(discovery.unmounted().empty()) << "nobody waits for what would not be used";
  EXPECT_EQ(discovery.problem_of("laser0"), "");

  discovery.hear("tf", *to_ros_transforms({kStamp, "base_link"}, {{"front", common::to_pose3({0.2, 0.0, 0.0})},
                                                                  {"wheels", common::to_pose3({0.3, 0.0, 0.0})}}));
  common::RecordingInfo later;
  discovery.describe(later);
  EXPECT_NEAR(later.calibration.lasers.at("laser0").T_base_laser.translation.norm(), 0.0, 1e-12);
  EXPECT_NEAR(discovery.T_child_base("odom0").translation().norm(), 0.0, 1e-12);
  ASSERT_EQ(later.notes.size(), 2U);
  EXPECT_NE(later.notes[0].find("came too late"), std::string::npos);
  EXPECT_NE(discovery.problem_of("laser0").find("came too late"), std::string::npos);
}

// The base of the robot on the floor and the one above it: in the plane they are the same.
TEST(SensorDiscovery, ATransformThatSaysWhatWasAssumedIsNeverTooLate) {
  SensorDiscovery discovery("base_link");
  discovery.hear("odom0", *to_ros_odometry({kStamp, "odom"}, "base_footprint", {kStamp, "odom0", {}, 0.0, 0.0}));
  EXPECT_NEAR(discovery.T_child_base("odom0").translation().norm(), 0.0, 1e-12);
  common::Pose3 above;
  above.translation.z() = 0.1;
  discovery.hear("tf", *to_ros_transforms({kStamp, "base_footprint"}, {{"base_link", above}}));
  EXPECT_EQ(discovery.problem_of("odom0"), "");
  common::RecordingInfo info;
  discovery.describe(info);
  EXPECT_TRUE(info.notes.empty());
}

}  // namespace
}  // namespace slamfuse::service
