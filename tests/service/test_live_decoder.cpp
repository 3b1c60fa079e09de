// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_decoder.hpp"

#include <gtest/gtest.h>

#include "service/sensor_to_ros.hpp"

namespace slamfuse::service {
namespace {

constexpr common::Nanoseconds kStamp = 1'700'000'000'000'000'000;

common::LaserCalibration laser(int beams) {
  common::LaserCalibration laser;
  laser.angle_min = -1.0;
  laser.angle_increment = 1.0;
  laser.beams = beams;
  laser.range_min = 0.1;
  laser.range_max = 5.0;
  return laser;
}

common::RecordingInfo robot() {
  common::RecordingInfo info;
  info.sensors["laser0"].kind = common::SensorKind::kLaser;
  info.calibration.lasers["laser0"] = laser(3);
  return info;
}

TEST(LiveDecoder, DecodesAScanOfTheKnownGeometry) {
  const auto info = robot();
  const LiveDecoder decoder(info);
  const LivePayload payload = to_ros_scan({kStamp, "front"}, {kStamp, "laser0", {1.0F, 2.0F, 3.0F}}, laser(3));
  const auto message = decoder.decode(payload, "laser0");
  ASSERT_TRUE(message) << message.error().message;
  EXPECT_EQ(common::stamp_of(*message), kStamp);
  EXPECT_EQ(std::get<common::LaserScan>(*message).ranges.size(), 3u);
}

TEST(LiveDecoder, RefusesAScanOfAnotherGeometryAndWhatIsNoSensorMessage) {
  const auto info = robot();
  const LiveDecoder decoder(info);
  const LivePayload other = to_ros_scan({kStamp, "front"}, {kStamp, "laser0", {1.0F, 2.0F}}, laser(2));
  EXPECT_FALSE(decoder.decode(other, "laser0"));
  EXPECT_FALSE(decoder.decode(LivePayload(idl::Message<idl::TFMessage>()), "laser0"));
  EXPECT_FALSE(decoder.decode(LivePayload(idl::Message<idl::CameraInfo>()), "laser0"));
}

TEST(LiveDecoder, KnowsTheFramesItWasTold) {
  const auto info = robot();
  LiveDecoder decoder(info);
  EXPECT_FALSE(decoder.knows_child_frame("odom0"));
  decoder.set_child_frame("odom0", {});
  EXPECT_TRUE(decoder.knows_child_frame("odom0"));
}

}  // namespace
}  // namespace slamfuse::service
