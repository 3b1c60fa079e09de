// SPDX-License-Identifier: BSD-3-Clause
// What an operator may ask of `slamfuse serve`, by `slamfuse call` and `initialpose`, while `slamfuse play` feeds it;
// and poses of other SLAM systems in the place of a half.
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/recording.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"
#include "service/map_bundle.hpp"
#include "service/ros_conversion.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"
#include "system/program.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class Operator : public testing::Test {
 protected:
  Operator() : participant_(network_.join()) { fs::create_directories(folder_); }
  ~Operator() override { fs::remove_all(folder_); }

  fs::path out() const { return folder_ / "out"; }

  Network network_;
  idl::Participant participant_;
  fs::path folder_ = fs::temp_directory_path() / ("slamfuse-operator-" + std::to_string(getpid()));
};

TEST_F(Operator, AsksForThingsWhileTheRobotDrives) {
  const pid_t service = start({SLAMFUSE_PROGRAM, "serve", "-o", out(), "--modules", "laser"});
  auto poses = idl::Reader<idl::PoseWithCovarianceStamped>::create(participant_, "slamfuse/pose",
                                                                   idl::QosProfile::kTransformInput)
                   .value();
  EXPECT_THAT(run_program({"call", "save_map"}).err, HasSubstr("nothing runs yet"));
  const pid_t player = start({SLAMFUSE_PROGRAM, "play", SLAMFUSE_DATA_DIR "/flat", "--wait", "4"});
  ASSERT_TRUE(poses.take(20s).value());

  const Outcome saved = run_program({"call", "save_map"});
  EXPECT_EQ(saved.exit_status, 0) << saved.err;
  const auto bundle = service::read_map_bundle(out() / "map");
  ASSERT_TRUE(bundle) << bundle.error().message;
  EXPECT_TRUE(bundle->summary.incomplete);

  EXPECT_EQ(run_program({"call", "sing"}).exit_status, 2);
  EXPECT_EQ(run_program({"call", "set_mode"}).exit_status, 2);
  EXPECT_THAT(run_program({"call", "set_mode", "sleep"}).err, HasSubstr("allowed: slam, localization"));
  EXPECT_THAT(run_program({"call", "load_map", "/no/such/map"}).err, HasSubstr("/no/such/map"));
  EXPECT_THAT(run_program({"call", "align_now"}).err, HasSubstr("align"));
  EXPECT_THAT(run_program({"call", "reinitialize_global_localization"}).err, HasSubstr("first set_mode localization"));

  // There is nothing to localise in before the robot has seen something from more than one place.
  for (double way = 0.0; way < 1.0;) {
    const auto pose = poses.take(20s).value();
    ASSERT_TRUE(pose);
    const idl::Point& at = (*pose)->pose.pose.position;
    way = std::hypot(at.x, at.y);
  }
  const Outcome localises = run_program({"call", "set_mode", "localization"});
  EXPECT_EQ(localises.exit_status, 0) << localises.err;
  EXPECT_THAT(localises.out, HasSubstr("running in mode localization"));
  const Outcome searched = run_program({"call", "reinitialize_global_localization"});
  EXPECT_EQ(searched.exit_status, 0) << searched.err;
  const Outcome again = run_program({"call", "set_mode", "slam"});
  EXPECT_EQ(again.exit_status, 0) << again.err;
  const Outcome loaded = run_program({"call", "load_map", out() / "map"});
  EXPECT_EQ(loaded.exit_status, 0) << loaded.err;

  kill(player, SIGINT);
  exit_status_of(player);
  kill(service, SIGINT);
  EXPECT_EQ(exit_status_of(service), 0);
}

// A robot of two other SLAM systems: odometry along x, the laser's poses half a metre aside, the visual's in feet.
class TwoOtherSystems {
 public:
  explicit TwoOtherSystems(const idl::Participant& participant)
      : odometry_(idl::Writer<idl::Odometry>::create(participant, "odom", idl::QosProfile::kOutput).value()),
        laser_(idl::Writer<idl::PoseWithCovarianceStamped>::create(participant, "other/laser", idl::QosProfile::kOutput)
                   .value()),
        visual_(idl::Writer<idl::PoseStamped>::create(participant, "other/visual", idl::QosProfile::kOutput).value()) {}

  void drive(std::chrono::seconds duration) {
    const auto start = Clock::now();
    for (int step = 0; Clock::now() - start < duration; ++step) {
      constexpr double kPeriod = 0.05;
      const auto stamp = 1'700'000'000'000'000'000LL + common::from_seconds(kPeriod * step);
      const double x = 0.5 * kPeriod * step;
      send_odometry(stamp, x);
      send_laser(stamp, x);
      send_visual(stamp, x);
      std::this_thread::sleep_for(std::chrono::duration<double>(kPeriod));
    }
  }

 private:
  void send_odometry(common::Nanoseconds stamp, double x) {
    idl::Message<idl::Odometry> message;
    message->header.stamp = service::to_ros_time(stamp);
    idl::assign(message->header.frame_id, "odom");
    idl::assign(message->child_frame_id, "base_link");
    message->pose.pose.position.x = x;
    message->pose.pose.orientation.w = 1.0;
    odometry_.write(message);
  }
  void send_laser(common::Nanoseconds stamp, double x) {
    laser_.write(service::to_ros_pose({stamp, "their_map"}, {x, 0.5, 0.0}, 1e-4 * Eigen::Matrix3d::Identity()));
  }
  void send_visual(common::Nanoseconds stamp, double x) {
    constexpr double kFeet = 3.28084;
    idl::Message<idl::PoseStamped> message;
    message->header.stamp = service::to_ros_time(stamp);
    idl::assign(message->header.frame_id, "world");
    message->pose.position.x = kFeet * x;
    message->pose.orientation.w = 1.0;
    visual_.write(message);
  }

  idl::Writer<idl::Odometry> odometry_;
  idl::Writer<idl::PoseWithCovarianceStamped> laser_;
  idl::Writer<idl::PoseStamped> visual_;
};

TEST_F(Operator, BringsOwnSlamSystems) {
  const pid_t service = start({SLAMFUSE_PROGRAM, "serve", "-o", out(), "--topic", "odom0=odom", "--topic",
                               "laser_pose=/other/laser", "--topic", "visual_pose=/other/visual"});
  auto poses = idl::Reader<idl::PoseWithCovarianceStamped>::create(participant_, "slamfuse/pose",
                                                                   idl::QosProfile::kTransformInput)
                   .value();
  TwoOtherSystems robot(participant_);
  robot.drive(6s);
  std::size_t received = 0;
  double y = 0.0;
  for (auto pose = poses.take(); pose && *pose; pose = poses.take(), ++received) y = (**pose)->pose.pose.position.y;
  EXPECT_GT(received, 5u);
  EXPECT_NEAR(y, 0.5, 0.05);
  EXPECT_THAT(run_program({"call", "save_map"}).err, HasSubstr("no half of ours makes a map"));
  EXPECT_THAT(run_program({"call", "set_mode", "localization"}).err, HasSubstr("no laser half runs"));
  EXPECT_NE(run_program({"call", "align_now"}).err, "");  // a straight line shows no scale to be sure of
  kill(service, SIGINT);
  EXPECT_EQ(exit_status_of(service), 0);
  EXPECT_TRUE(fs::exists(out() / "laser.tum"));
  EXPECT_TRUE(fs::exists(out() / "visual.tum"));
}

}  // namespace
}  // namespace slamfuse::system
