// SPDX-License-Identifier: BSD-3-Clause
// The program on ROS bags: small ones made of the demo recording, and the real ones where they are.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/recording.hpp"
#include "common/ros_bag_samples.hpp"
#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using common::samples::BagSample;
using common::samples::Wire;
using testing::HasSubstr;

constexpr common::Nanoseconds kLength = 12 * common::kNanosecondsPerSecond;

/// The first seconds of the demo recording's laser, odometry and truth as messages of ROS.
std::vector<BagSample> beginning_of_flat_as_messages(Wire wire) {
  const auto recording = common::open_recording(flat());
  EXPECT_TRUE(recording) << recording.error().message;
  const common::LaserCalibration& laser = (*recording)->info().calibration.lasers.at("laser0");
  const common::Nanoseconds begin = (*recording)->info().first_stamp;
  std::vector<BagSample> samples;
  samples.push_back({"/tf_static", "tf2_msgs/TFMessage", begin,
                     transforms_message(wire, begin, {{"base_link", "laser", laser.T_base_laser}})});
  while (true) {
    const auto item = (*recording)->next();
    const auto* message = item && *item ? std::get_if<common::SensorMessage>(&**item) : nullptr;
    if (message == nullptr || common::stamp_of(*message) > begin + kLength) break;
    if (const auto* scan = std::get_if<common::LaserScan>(message)) {
      common::samples::SampleScan sample;
      sample.stamp = scan->stamp;
      sample.angle_min = static_cast<float>(laser.angle_min);
      sample.angle_increment = static_cast<float>(laser.angle_increment);
      sample.time_increment = static_cast<float>(laser.sweep_duration / (laser.beams - 1));
      sample.range_min = static_cast<float>(laser.range_min);
      sample.range_max = static_cast<float>(laser.range_max);
      sample.ranges = scan->ranges;
      samples.push_back({"/scan", "sensor_msgs/LaserScan", scan->stamp, scan_message(wire, sample)});
    } else if (const auto* odometry = std::get_if<common::WheelOdometry>(message)) {
      samples.push_back({"/odom", "nav_msgs/Odometry", odometry->stamp,
                         odometry_message(wire, odometry->stamp, "base_link", common::to_pose3(odometry->pose),
                                          odometry->forward_speed, odometry->turn_rate)});
    }
  }
  const auto true_path = common::read_ground_truth(flat());
  EXPECT_TRUE(true_path) << true_path.error().message;
  for (const auto& truth : *true_path) {
    if (truth.stamp > begin + kLength) break;
    samples.push_back({"/mocap/pose", "geometry_msgs/PoseStamped", truth.stamp,
                       pose_message(wire, truth.stamp, common::to_pose3(truth.pose))});
  }
  return samples;
}

/// Both bags in a scratch folder.
struct Bags {
  explicit Bags(const Scratch& scratch) : ros1(scratch / "flat.bag"), ros2(scratch / "flat") {
    write_text(ros1, common::samples::ros1_bag(beginning_of_flat_as_messages(Wire::kRos1), "lz4", 50));
    common::samples::write_ros2_bag(ros2, beginning_of_flat_as_messages(Wire::kCdr));
  }
  fs::path ros1;
  fs::path ros2;
};

TEST(Bags, OfBothRosVersionsGiveTheSamePath) {
  const Scratch scratch;
  const Bags bags(scratch);
  for (const auto& [bag, out] : {std::pair{bags.ros1, "out1"}, std::pair{bags.ros2, "out2"}}) {
    const Outcome outcome = run_program({"run", bag.string(), "-o", (scratch / out).string()});
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    const auto metrics = read_json(scratch / (std::string(out) + "/metrics.json"));
    EXPECT_LT(metrics["accuracy"]["laser"]["ate_rmse_m"], 0.03);
    EXPECT_EQ(metrics["modules"]["laser"]["rejected"], 0);
    EXPECT_EQ(metrics["events"][0]["kind"], "note") << "what was chosen is told";
  }
  for (const char* file : {"laser.tum", "laser_final.tum", "odometry.tum", "fused.tum"}) {
    EXPECT_EQ(read_text(scratch / ("out1/" + std::string(file))), read_text(scratch / ("out2/" + std::string(file))))
        << file;
  }
}

TEST(Bags, AreDescribedWithWhatWasChosen) {
  const Scratch scratch;
  const Bags bags(scratch);
  const Outcome outcome = run_program({"info", bags.ros2.string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("format ros2"));
  EXPECT_THAT(outcome.out, HasSubstr("laser0 is /scan (sensor_msgs/LaserScan, frame laser)"));
  EXPECT_THAT(outcome.out, HasSubstr("odom0 is /odom"));
  EXPECT_THAT(outcome.out, HasSubstr("ground truth: "));

  const Outcome without = run_program({"info", bags.ros1.string(), "--topic", "odom0=none"});
  ASSERT_EQ(without.exit_status, 0) << without.err;
  EXPECT_THAT(without.out, testing::Not(HasSubstr("odom0")));
  const Outcome wrong = run_program({"info", bags.ros1.string(), "--topic", "laser0=/nowhere"});
  EXPECT_EQ(wrong.exit_status, 2);
  EXPECT_THAT(wrong.err, HasSubstr("/nowhere is not in the recording (possible here: /scan)"));
  EXPECT_EQ(run_program({"info", flat().string(), "--topic", "laser0=/scan"}).exit_status, 2) << "not a bag";
}

TEST(Bags, CutShortAreReadUpToTheCut) {
  const Scratch scratch;
  const Bags bags(scratch);
  const std::string whole = read_text(bags.ros1);
  write_text(bags.ros1, whole.substr(0, whole.size() * 2 / 3));
  const Outcome outcome = run_program({"run", bags.ros1.string(), "-o", (scratch / "out").string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_THAT(read_text(scratch / "out/metrics.json"), HasSubstr("the chunk at byte"));
}

TEST(Bags, OfTheJackalMeetTheBarWithoutOdometry) {
  const char* root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr || *root == '\0') GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: needs real/jackal";
  const std::string stem = (fs::path(root) / "real/jackal/test_2026-02-17-15-54-31").string();
  const Scratch scratch;
  for (const auto& [bag, out] : {std::pair{stem + ".bag", "out1"}, std::pair{stem, "out2"}}) {
    const Outcome outcome = run_program({"run", bag, "-o", (scratch / out).string()});
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  }
  EXPECT_EQ(read_text(scratch / "out1/laser.tum"), read_text(scratch / "out2/laser.tum"));
  for (const char* file : {"out1/laser.tum", "out1/laser_final.tum", "out1/fused.tum"}) {
    const Outcome judged = run_program({"evaluate", (scratch / file).string(), stem, "--fit-offset", "--json"});
    ASSERT_EQ(judged.exit_status, 0) << judged.err;
    const auto accuracy = nlohmann::json::parse(judged.out);
    EXPECT_LT(accuracy["ate_rmse_m"], 0.03) << file;
    EXPECT_LT(accuracy["heading_rmse_deg"], 3.0) << file;
  }
}

TEST(Bags, OfTheNeatoRun) {
  const char* root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr || *root == '\0') GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: needs real/olin_neato";
  const std::string bag = (fs::path(root) / "real/olin_neato").string();
  const Scratch scratch;
  for (const char* topic : {"odom0=/odom", "odom0=/tf", "odom0=none"}) {
    const Outcome outcome = run_program({"run", bag, "-o", (scratch / "out").string(), "--topic", topic});
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    const auto metrics = read_json(scratch / "out/metrics.json");
    EXPECT_EQ(metrics["modules"]["laser"]["poses"], 357) << topic;
    // The first transforms of /tf are 5 s old when they arrive, and the recording's time counts from there.
    EXPECT_GT(metrics["modules"]["laser"]["coverage"], 0.9) << topic;
  }
}

}  // namespace
}  // namespace slamfuse::system
