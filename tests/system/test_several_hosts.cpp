// SPDX-License-Identifier: BSD-3-Clause
// Laser, visual and fusion as three processes on three hosts with only DDS between them, a robot on a fourth. Each
// is killed and started again while the robot drives: the fusion says so, and its pose goes on.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "idl/reader.hpp"
#include "service/ros_conversion.hpp"
#include "system/child_process.hpp"
#include "system/hosts.hpp"
#include "system/network.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

const std::string kFlat = SLAMFUSE_DATA_DIR "/flat";

// Keeps what arrives on a topic; `use` is called with the listener locked.
template <class T>
std::jthread listen(const idl::Participant& participant, const std::string& topic, std::mutex& mutex,
                    std::function<void(const T&)> use) {
  return std::jthread([&participant, topic, &mutex, use = std::move(use)](const std::stop_token& done) {
    auto reader = idl::Reader<T>::create(participant, topic, idl::QosProfile::kTransformInput);
    while (reader && !done.stop_requested()) {
      const auto message = reader->take(50ms);
      if (!message || !*message) continue;
      const std::lock_guard lock(mutex);
      use(***message);
    }
  });
}

class Listener {
 public:
  explicit Listener(const idl::Participant& participant)
      : pose_thread_(listen<idl::PoseWithCovarianceStamped>(
            participant, "slamfuse/pose", mutex_,
            [this](const auto& message) {
              fused_.emplace(service::from_ros_time(message.header.stamp), pose_of(message));
            })),
        laser_thread_(listen<idl::PoseWithCovarianceStamped>(participant, "laser/slamfuse/pose", mutex_,
                                                             [this](const auto&) { ++laser_; })),
        visual_thread_(listen<idl::PoseWithCovarianceStamped>(participant, "visual/slamfuse/pose", mutex_,
                                                              [this](const auto&) { ++visual_; })),
        transform_thread_(listen<idl::TFMessage>(participant, "tf", mutex_,
                                                 [this](const auto& message) {
                                                   const auto& first = message.transforms._buffer[0];
                                                   if (idl::text_of(first.header.frame_id) == "map") ++transforms_;
                                                 })),
        diagnostics_thread_(listen<idl::DiagnosticArray>(participant, "diagnostics", mutex_,
                                                         [this](const auto& message) { note(message); })) {}

  common::Trajectory2 fused() {
    const std::lock_guard lock(mutex_);
    common::Trajectory2 path;
    for (const auto& [stamp, pose] : fused_) path.push_back({stamp, pose});
    return path;
  }
  std::size_t poses() {
    const std::lock_guard lock(mutex_);
    return fused_.size();
  }
  int laser() {
    const std::lock_guard lock(mutex_);
    return laser_;
  }
  int visual() {
    const std::lock_guard lock(mutex_);
    return visual_;
  }
  int transforms() {
    const std::lock_guard lock(mutex_);
    return transforms_;
  }
  // The newest verdict of a node on a topic.
  std::string verdict(const std::string& row) {
    const std::lock_guard lock(mutex_);
    return verdicts_[row];
  }

 private:
  static common::Pose2 pose_of(const idl::PoseWithCovarianceStamped& message) {
    const auto& pose = message.pose.pose;
    return {pose.position.x, pose.position.y, 2.0 * std::atan2(pose.orientation.z, pose.orientation.w)};
  }
  void note(const idl::DiagnosticArray& message) {
    for (std::uint32_t i = 0; i < message.status._length; ++i) {
      const idl::DiagnosticStatus& status = message.status._buffer[i];
      verdicts_[idl::text_of(status.name)] = idl::text_of(status.message);
    }
  }

  std::mutex mutex_;
  std::map<common::Nanoseconds, common::Pose2> fused_;  // by stamp
  int laser_ = 0;
  int visual_ = 0;
  int transforms_ = 0;
  std::map<std::string, std::string> verdicts_;
  std::jthread pose_thread_;
  std::jthread laser_thread_;
  std::jthread visual_thread_;
  std::jthread transform_thread_;
  std::jthread diagnostics_thread_;
};

class SeveralHosts : public testing::Test {
 protected:
  SeveralHosts() { fs::create_directories(folder_); }
  ~SeveralHosts() override { fs::remove_all(folder_); }

  // Starts `serve` on the host of its name.
  pid_t serve(const Hosts& hosts, const std::string& host, const std::vector<std::string>& more) const {
    std::vector<std::string> words{SLAMFUSE_PROGRAM,
                                   "serve",
                                   "-o",
                                   folder_ / host,
                                   "--topic",
                                   "odom0=/odom",
                                   "--set",
                                   "service.dds.network=all",
                                   "--set",
                                   "service.save_interval=2"};
    words.insert(words.end(), more.begin(), more.end());
    return hosts.start(host, words);
  }
  pid_t laser(const Hosts& hosts, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words{"--modules", "laser",
                                   "--topic",   "laser0=/scan",
                                   "--set",     "service.dds.namespace=/laser",
                                   "--set",     "service.dds.publish_tf=false"};
    words.insert(words.end(), more.begin(), more.end());
    return serve(hosts, "laser", words);
  }
  pid_t visual(const Hosts& hosts) const {
    return serve(hosts, "visual",
                 {"--modules", "visual", "--topic", "cam0=/cam0/image_raw", "--topic", "cam1=/cam1/image_raw",
                  "--readout", "cam0=0.016", "--readout", "cam1=0.016", "--set", "service.dds.namespace=/visual",
                  "--set", "service.dds.publish_tf=false"});
  }
  pid_t fusion(const Hosts& hosts) const {
    return serve(hosts, "fusion",
                 {"--topic", "laser_pose=/laser/slamfuse/pose", "--topic", "visual_pose=/visual/slamfuse/pose", "--set",
                  "service.external_pose.laser_restart=same_map", "--set",
                  "service.external_pose.laser_initialpose=/laser/initialpose", "--set",
                  "service.external_pose.visual_initialpose=/visual/initialpose"});
  }

  static void kill_at_once(pid_t process) {
    kill(process, SIGKILL);
    exit_status_of(process);
  }

  const fs::path folder_ = fs::temp_directory_path() / ("slamfuse-hosts-" + std::to_string(getpid()));
};

TEST_F(SeveralHosts, AnyProcessMayDieAndComeBack) {
  std::string why_not;
  auto hosts = Hosts::create({"robot", "laser", "visual", "fusion"}, why_not);
  if (!hosts) {
    std::fprintf(stderr, "NOT TESTED: several hosts: %s\n", why_not.c_str());
    GTEST_SKIP() << why_not;
  }
  const Network network(idl::Network::kAll);
  pid_t laser_process = laser(*hosts);
  pid_t visual_process = visual(*hosts);
  pid_t fusion_process = fusion(*hosts);
  ASSERT_TRUE(hosts->enter("fusion"));
  const auto participant = network.join();
  Listener listener(participant);
  hosts->leave();
  const pid_t robot = hosts->start(
      "robot", {SLAMFUSE_PROGRAM, "play", kFlat, "--to", "60", "--wait", "20", "--set", "service.dds.network=all"});

  // A pose for each odometry message, 20 in a second, is there all the time; half of them must be.
  const auto goes_on = [&](const char* when) {
    const std::size_t before = listener.poses();
    std::this_thread::sleep_for(2s);
    EXPECT_GE(listener.poses(), before + 20) << when;
  };
  const auto says = [&](const std::string& row, const std::string& what) {
    EXPECT_TRUE(becomes_true([&] { return listener.verdict(row).find(what) != std::string::npos; }, 5s))
        << row << " says '" << listener.verdict(row) << "', not '" << what << "'";
  };
  const std::string laser_row = "slamfuse: input laser/slamfuse/pose";
  const std::string visual_row = "slamfuse: input visual/slamfuse/pose";

  ASSERT_TRUE(becomes_true([&] { return listener.poses() > 0; }, 30s));
  std::this_thread::sleep_for(14s);
  goes_on("all are there");
  says(laser_row, "ok");
  says(visual_row, "ok");

  kill_at_once(laser_process);
  goes_on("the laser process is gone");
  says(laser_row, "silent");
  laser_process = laser(*hosts, {"--map", folder_ / "laser/map"});
  says(laser_row, "ok");
  goes_on("the laser process is back");
  std::this_thread::sleep_for(3s);

  kill_at_once(visual_process);
  goes_on("the visual process is gone");
  says(visual_row, "silent");
  visual_process = visual(*hosts);
  says(visual_row, "ok");
  goes_on("the visual process is back");
  std::this_thread::sleep_for(8s);

  kill_at_once(fusion_process);
  const int laser_before = listener.laser();
  const int visual_before = listener.visual();
  std::this_thread::sleep_for(2s);
  EXPECT_GE(listener.laser(), laser_before + 20);
  EXPECT_GE(listener.visual(), visual_before + 20);
  const std::size_t before = listener.poses();
  fusion_process = fusion(*hosts);
  EXPECT_TRUE(becomes_true([&] { return listener.poses() > before; }, 10s));
  goes_on("the fusion process is back");

  EXPECT_EQ(exit_status_of(robot), 0);
  std::this_thread::sleep_for(500ms);
  // map -> odom comes from the fusion alone: one with each pose.
  EXPECT_NEAR(listener.transforms(), static_cast<int>(listener.poses()), 20);
  for (const pid_t process : {laser_process, visual_process, fusion_process}) kill(process, SIGINT);
  for (const pid_t process : {laser_process, visual_process, fusion_process}) EXPECT_EQ(exit_status_of(process), 0);

  const auto truth = common::read_ground_truth(kFlat);
  ASSERT_TRUE(truth);
  const auto accuracy = common::evaluate_trajectory(listener.fused(), *truth, {});
  ASSERT_TRUE(accuracy);
  std::printf("poses of the fusion over all: %zu, ATE %.3f m rmse, %.3f m at most\n", listener.poses(),
              accuracy->ate_rmse_m, accuracy->ate_max_m);
  constexpr double kLost = 0.3;  // [m] a pose this far off is a wrong one
  EXPECT_LT(accuracy->ate_max_m, kLost);
}

}  // namespace
}  // namespace slamfuse::system
