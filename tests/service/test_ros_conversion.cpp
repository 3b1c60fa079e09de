// SPDX-License-Identifier: BSD-3-Clause
#include "service/ros_conversion.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

const RosHeader kHeader{1700000000123456789, "map"};

TEST(ToRosTime, SplitsSecondsAndNanoseconds) {
  const idl::Time time = to_ros_time(1700000000123456789);
  EXPECT_EQ(time.sec, 1700000000);
  EXPECT_EQ(time.nanosec, 123456789u);
}

TEST(ToRosTime, RoundsSecondsDownBeforeTheEpoch) {
  const idl::Time time = to_ros_time(-1);
  EXPECT_EQ(time.sec, -1);
  EXPECT_EQ(time.nanosec, 999999999u);
}

TEST(ToRosTime, IsUndoneByFromRosTime) {
  for (const common::Nanoseconds stamp : {common::Nanoseconds{0}, common::Nanoseconds{-1},
                                          common::Nanoseconds{-1500000000}, common::Nanoseconds{1700000000999999999}}) {
    EXPECT_EQ(from_ros_time(to_ros_time(stamp)), stamp);
  }
}

TEST(ToRosTime, SaturatesWhereThirtyTwoBitsEnd) {
  EXPECT_EQ(to_ros_time(std::numeric_limits<common::Nanoseconds>::max()).sec, std::numeric_limits<std::int32_t>::max());
}

TEST(YawToQuaternion, IsAUnitTurnAboutZThatReadsBack) {
  for (const double yaw : {0.0, 0.1, -2.0, 3.1, -3.1, std::numbers::pi}) {
    const idl::Quaternion q = yaw_to_quaternion(yaw);
    EXPECT_EQ(q.x, 0.0);
    EXPECT_EQ(q.y, 0.0);
    EXPECT_NEAR(q.z * q.z + q.w * q.w, 1.0, 1e-15);
    EXPECT_NEAR(quaternion_to_yaw(q), yaw, 1e-15);
  }
}

TEST(YawToQuaternion, TurnsLeftForAPositiveYaw) {
  const idl::Quaternion q = yaw_to_quaternion(std::numbers::pi / 2);
  EXPECT_NEAR(q.z, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(q.w, std::sqrt(0.5), 1e-15);
}

TEST(ToRosPose, PutsThePlanarCovarianceAtXYAndYaw) {
  Eigen::Matrix3d covariance;
  covariance << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  const auto message = to_ros_pose(kHeader, {1.5, -2.5, 0.3}, covariance);
  EXPECT_EQ(idl::text_of(message->header.frame_id), "map");
  EXPECT_EQ(from_ros_time(message->header.stamp), kHeader.stamp);
  EXPECT_EQ(message->pose.pose.position.x, 1.5);
  EXPECT_EQ(message->pose.pose.position.y, -2.5);
  EXPECT_EQ(message->pose.pose.position.z, 0.0);
  EXPECT_NEAR(quaternion_to_yaw(message->pose.pose.orientation), 0.3, 1e-15);
  const double* c = message->pose.covariance;
  EXPECT_EQ(c[0], 1.0);
  EXPECT_EQ(c[1], 2.0);
  EXPECT_EQ(c[5], 3.0);
  EXPECT_EQ(c[6], 2.0);
  EXPECT_EQ(c[7], 4.0);
  EXPECT_EQ(c[11], 5.0);
  EXPECT_EQ(c[30], 3.0);
  EXPECT_EQ(c[31], 5.0);
  EXPECT_EQ(c[35], 6.0);
  EXPECT_EQ(c[14], 0.0) << "height";
  double sum = 0.0;
  for (int i = 0; i < 36; ++i) sum += c[i];
  EXPECT_EQ(sum, 31.0) << "nothing else is set";
}

TEST(ToRosTransform, NamesParentAndChild) {
  const auto message = to_ros_transform(kHeader, "odom", {1.0, 2.0, -1.0});
  ASSERT_EQ(message->transforms._length, 1u);
  const idl::TransformStamped& transform = message->transforms._buffer[0];
  EXPECT_EQ(idl::text_of(transform.header.frame_id), "map");
  EXPECT_EQ(idl::text_of(transform.child_frame_id), "odom");
  EXPECT_EQ(transform.transform.translation.x, 1.0);
  EXPECT_EQ(transform.transform.translation.y, 2.0);
  EXPECT_NEAR(quaternion_to_yaw(transform.transform.rotation), -1.0, 1e-15);
}

TEST(ToRosGrid, KeepsCellsOriginAndResolution) {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = 3;
  grid.height = 2;
  grid.origin = {-1.0, 4.0};
  grid.cells = {0, 50, 100, -1, -1, 7};
  const auto message = to_ros_grid(kHeader, grid);
  EXPECT_FLOAT_EQ(message->info.resolution, 0.1F);
  EXPECT_EQ(message->info.width, 3u);
  EXPECT_EQ(message->info.height, 2u);
  EXPECT_EQ(message->info.origin.position.x, -1.0);
  EXPECT_EQ(message->info.origin.position.y, 4.0);
  EXPECT_EQ(message->info.origin.orientation.w, 1.0);
  ASSERT_EQ(message->data._length, 6u);
  EXPECT_TRUE(std::equal(grid.cells.begin(), grid.cells.end(), message->data._buffer));
}

common::Trajectory2 walk(std::size_t poses) {
  common::Trajectory2 path;
  for (std::size_t i = 0; i < poses; ++i) {
    path.push_back({static_cast<common::Nanoseconds>(i), {static_cast<double>(i), 0.0, 0.0}});
  }
  return path;
}

TEST(ToRosPath, KeepsEveryPoseOfAShortPath) {
  const auto message = to_ros_path(kHeader, walk(5), 5);
  ASSERT_EQ(message->poses._length, 5u);
  for (std::uint32_t i = 0; i < 5; ++i) {
    EXPECT_EQ(message->poses._buffer[i].pose.position.x, i);
    EXPECT_EQ(from_ros_time(message->poses._buffer[i].header.stamp), i);
    EXPECT_EQ(idl::text_of(message->poses._buffer[i].header.frame_id), "map");
  }
}

TEST(ToRosPath, ThinsALongPathAndKeepsItsEnds) {
  const auto message = to_ros_path(kHeader, walk(1001), 11);
  ASSERT_EQ(message->poses._length, 11u);
  EXPECT_EQ(message->poses._buffer[0].pose.position.x, 0.0);
  EXPECT_EQ(message->poses._buffer[1].pose.position.x, 100.0);
  EXPECT_EQ(message->poses._buffer[10].pose.position.x, 1000.0);
}

TEST(ToRosPath, OfNothingIsEmpty) {
  EXPECT_EQ(to_ros_path(kHeader, {}, 10)->poses._length, 0u);
  EXPECT_EQ(to_ros_path(kHeader, walk(1), 10)->poses._length, 1u);
}

TEST(ToRosCloud, PacksPointsAndLeavesOutWhatIsNotFinite) {
  std::vector<common::Landmark> landmarks(3);
  landmarks[0].position = {1.0, 2.0, 3.0};
  landmarks[0].gray = 200;
  landmarks[1].position.x() = std::nan("");
  landmarks[2].position = {4.0, 5.0, 6.0};
  const auto message = to_ros_cloud(kHeader, landmarks);
  EXPECT_EQ(message->width, 2u);
  EXPECT_EQ(message->height, 1u);
  EXPECT_EQ(message->point_step, 16u);
  EXPECT_EQ(message->row_step, 32u);
  ASSERT_EQ(message->data._length, 32u);
  float values[8];
  std::memcpy(values, message->data._buffer, sizeof values);
  EXPECT_EQ(values[0], 1.0F);
  EXPECT_EQ(values[2], 3.0F);
  EXPECT_EQ(values[3], 200.0F);
  EXPECT_EQ(values[4], 4.0F);
  ASSERT_EQ(message->fields._length, 4u);
  EXPECT_EQ(idl::text_of(message->fields._buffer[2].name), "z");
  EXPECT_EQ(message->fields._buffer[2].offset, 8u);
  EXPECT_EQ(message->fields._buffer[2].datatype, 7);
}

TEST(ToRosStatus, PutsTheFusedVerdictInFrontAndTheHalvesBehind) {
  const auto message =
      to_ros_status(kHeader, {{1, common::PoseSource::kLaser, fusion::Verdict::kSuspect, 0.4, {"a", "b"}},
                              {2, common::PoseSource::kFused, fusion::Verdict::kTracking, 0.9, {}},
                              {2, common::PoseSource::kVisual, fusion::Verdict::kLost, 0.0, {"c"}}});
  EXPECT_EQ(message->state, 0);
  EXPECT_EQ(message->score, 0.9);
  EXPECT_EQ(message->reasons._length, 0u);
  ASSERT_EQ(message->sources._length, 2u);
  const idl::SourceStatus& laser = message->sources._buffer[0];
  EXPECT_EQ(idl::text_of(laser.source), "laser");
  EXPECT_EQ(laser.state, 1);
  ASSERT_EQ(laser.reasons._length, 2u);
  EXPECT_EQ(idl::text_of(laser.reasons._buffer[1]), "b");
  EXPECT_EQ(message->sources._buffer[1].state, 2);
}

TEST(ToRosStatus, IsLostBeforeTheFusionHasSpoken) { EXPECT_EQ(to_ros_status(kHeader, {})->state, 2); }

}  // namespace
}  // namespace slamfuse::service
