// SPDX-License-Identifier: BSD-3-Clause
// `slamfuse run --dds` heard by another process that knows nothing but ROS 2 names and types.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/tum.hpp"
#include "idl/private_domain.hpp"
#include "service/grid_file.hpp"
#include "system/child_process.hpp"

namespace slamfuse {
namespace {

using namespace std::chrono_literals;
using system::appears;
using system::exit_status_of;
using system::start;

std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

struct ReceivedPose {
  std::string frame;
  std::string child;  // of a transform
  common::Pose2 pose;
  double variance_x = 0.0;
  double variance_yaw = 0.0;
};

struct Received {
  std::map<common::Nanoseconds, ReceivedPose> poses;
  std::map<common::Nanoseconds, ReceivedPose> transforms;
  std::size_t longest_path = 0;
  std::string map_frame;
  common::OccupancyGrid map;  // the last one
};

Received read_received(const std::filesystem::path& folder) {
  Received received;
  std::istringstream lines(content_of(folder / "messages.txt"));
  std::string kind;
  common::Nanoseconds stamp = 0;
  std::string frame;
  while (lines >> kind >> stamp >> frame) {
    if (kind == "path") {
      std::size_t poses = 0;
      lines >> poses;
      received.longest_path = std::max(received.longest_path, poses);
    } else if (kind == "map") {
      received.map_frame = frame;
      common::OccupancyGrid& map = received.map;
      lines >> map.resolution >> map.width >> map.height >> map.origin.x() >> map.origin.y();
    } else {
      ReceivedPose pose;
      pose.frame = frame;
      double qz = 0.0;
      double qw = 1.0;
      if (kind == "tf") lines >> pose.child;
      lines >> pose.pose.x >> pose.pose.y >> qz >> qw;
      pose.pose.theta = common::normalize_angle(2.0 * std::atan2(qz, qw));
      if (kind == "pose") lines >> pose.variance_x >> pose.variance_yaw;
      (kind == "pose" ? received.poses : received.transforms)[stamp] = pose;
    }
  }
  const std::string cells = content_of(folder / "map.raw");
  received.map.cells.assign(cells.begin(), cells.end());
  return received;
}

// One short run for all tests, with a listener beside it.
class RunDds : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::filesystem::temp_directory_path() / ("slamfuse-run-dds-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    const idl::PrivateDomain domain;
    const idl::ScopedEnvironment id("ROS_DOMAIN_ID", "77");
    const idl::ScopedEnvironment localhost("ROS_LOCALHOST_ONLY", "1");
    const pid_t listener = start({SLAMFUSE_DDS_RECEIVER, folder_});
    const bool listening = appears(folder_ / "ready", 20s);
    const pid_t run = start({SLAMFUSE_PROGRAM, "run", SLAMFUSE_DATA_DIR "/flat", "-o", out(), "--to", "12", "--dds",
                             "--set", "service.dds.reader_wait=20"});
    run_status_ = exit_status_of(run);
    listener_status_ = exit_status_of(listener);
    if (listening) received_ = read_received(folder_);
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder_); }

  void SetUp() override {
    ASSERT_EQ(run_status_, 0);
    ASSERT_EQ(listener_status_, 0);
  }

  static std::filesystem::path out() { return folder_ / "out"; }
  static common::Trajectory2 trajectory(const std::string& name) {
    const auto read = common::read_trajectory(out() / name);
    return read ? common::to_planar(*read) : common::Trajectory2();
  }

  static inline std::filesystem::path folder_;
  static inline Received received_;
  static inline int run_status_ = -1;
  static inline int listener_status_ = -1;
};

// Of fused.tum: positions have nine decimals, angles come from twelve.
constexpr double kRounding = 2e-9;

TEST_F(RunDds, SendsTheCorrectedPosesOfFusedTum) {
  const auto fused = trajectory("fused.tum");
  ASSERT_GT(fused.size(), 20u);
  std::size_t arrived = 0;
  std::size_t sent = 0;
  common::Nanoseconds last = 0;
  for (const auto& expected : fused) {
    if (expected.stamp <= last) continue;  // of a stamp the first goes out
    last = expected.stamp;
    ++sent;
    const auto found = received_.poses.find(expected.stamp);
    if (found == received_.poses.end()) continue;
    ++arrived;
    EXPECT_EQ(found->second.frame, "map");
    EXPECT_NEAR(found->second.pose.x, expected.pose.x, kRounding);
    EXPECT_NEAR(found->second.pose.y, expected.pose.y, kRounding);
    EXPECT_NEAR(common::angle_difference(found->second.pose.theta, expected.pose.theta), 0.0, kRounding);
    EXPECT_GT(found->second.variance_x, 0.0);
    EXPECT_GT(found->second.variance_yaw, 0.0);
  }
  // Keep-last queues may overwrite under load; what arrived must be right.
  EXPECT_GE(arrived, sent * 9 / 10);
}

TEST_F(RunDds, SendsNoPoseThatIsNotInFusedTum) {
  std::map<common::Nanoseconds, common::Pose2> expected;
  for (const auto& stamped : trajectory("fused.tum")) expected[stamped.stamp] = stamped.pose;
  for (const auto& [stamp, pose] : received_.poses) EXPECT_TRUE(expected.contains(stamp)) << stamp;
}

TEST_F(RunDds, SendsATransformThatTakesTheOdometryToThePose) {
  const auto odometry = common::sorted_by_stamp(trajectory("odometry.tum"));
  std::size_t compared = 0;
  for (const auto& [stamp, transform] : received_.transforms) {
    EXPECT_EQ(transform.frame, "map");
    EXPECT_EQ(transform.child, "odom");
    const auto pose = received_.poses.find(stamp);
    const auto T_odom_base = common::pose_at(odometry, stamp, common::kNanosecondsPerSecond / 5);
    if (pose == received_.poses.end() || !T_odom_base) continue;
    ++compared;
    const common::Pose2 T_map_base = transform.pose * *T_odom_base;
    // The run extrapolates the odometry to the newest stamp, here it is interpolated.
    EXPECT_NEAR(T_map_base.x, pose->second.pose.x, 0.02);
    EXPECT_NEAR(T_map_base.y, pose->second.pose.y, 0.02);
    EXPECT_NEAR(common::angle_difference(T_map_base.theta, pose->second.pose.theta), 0.0, 0.03);
  }
  EXPECT_GT(compared, 20u);
}

TEST_F(RunDds, SendsTheMapOfGridPgm) {
  EXPECT_EQ(received_.map_frame, "map");
  const auto size = static_cast<std::size_t>(received_.map.width) * static_cast<std::size_t>(received_.map.height);
  ASSERT_GT(size, 0u);
  ASSERT_EQ(received_.map.cells.size(), size);
  std::string pgm;
  service::grid_to_pgm(received_.map, [&](std::string_view piece) { pgm += piece; });
  EXPECT_EQ(pgm, content_of(out() / "map" / "grid.pgm"));
  std::istringstream image(pgm);
  const auto saved = service::grid_from_files(image, content_of(out() / "map" / "grid.yaml"));
  ASSERT_TRUE(saved) << saved.error().message;
  EXPECT_FLOAT_EQ(static_cast<float>(received_.map.resolution), static_cast<float>(saved->resolution));
  EXPECT_NEAR(received_.map.origin.x(), saved->origin.x(), 1e-9);
  EXPECT_NEAR(received_.map.origin.y(), saved->origin.y(), 1e-9);
}

TEST_F(RunDds, SendsThePath) { EXPECT_GT(received_.longest_path, 20u); }

}  // namespace
}  // namespace slamfuse
