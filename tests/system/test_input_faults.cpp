// SPDX-License-Identifier: BSD-3-Clause
// What a robot's inputs may do to `slamfuse serve`, in one drive: silence, doubled and swapped messages, a clock that
// jumps an hour ahead and back. Each has its diagnosis within 2 s, and poses come again within 3 s.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/replay.hpp"
#include "idl/reader.hpp"
#include "service/recording_publisher.hpp"
#include "service/ros_conversion.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::HasSubstr;

constexpr common::Nanoseconds kHour = 3600 * common::kNanosecondsPerSecond;

// The laser and the odometry of the demo recording in real time, as a fault lets them through.
class Robot {
 public:
  // Publishes a message with this stamp.
  using Publish = std::function<void(const common::SensorMessage&, common::Nanoseconds)>;
  using Fault = std::function<void(const common::SensorMessage&, common::Nanoseconds, const Publish&)>;

  explicit Robot(const idl::Participant& participant)
      : recording_(*common::replay(*common::open_recording(SLAMFUSE_DATA_DIR "/flat"), only_laser_and_odometry())),
        publisher_(*service::RecordingPublisher::create(participant, without_cameras(recording_->info()))),
        start_(Clock::now()) {}

  bool wait_for_service() { return publisher_->wait_for_readers(20.0); }

  void drive(std::chrono::milliseconds duration, const Fault& fault) {
    const auto end = Clock::now() + duration;
    while (Clock::now() < end) {
      const auto item = recording_->next();
      if (!item || !*item) return;
      const auto* message = std::get_if<common::SensorMessage>(&**item);
      if (message == nullptr) continue;
      const common::Nanoseconds stamp = common::stamp_of(*message);
      if (!first_) {
        first_ = stamp;
        start_ = Clock::now();
        publisher_->introduce(stamp);
      }
      std::this_thread::sleep_until(start_ + std::chrono::nanoseconds(stamp - *first_));
      fault(*message, stamp, [this](const auto& sent, common::Nanoseconds as) { publisher_->publish(sent, as); });
    }
  }

 private:
  static common::ReplayOptions only_laser_and_odometry() {
    common::ReplayOptions options;
    options.only_sensors = {"laser0", "odom0"};
    return options;
  }

  static common::RecordingInfo without_cameras(common::RecordingInfo info) {
    std::erase_if(info.sensors, [](const auto& sensor) { return sensor.second.kind == common::SensorKind::kCamera; });
    info.calibration.cameras.clear();
    return info;
  }

  std::unique_ptr<common::Recording> recording_;
  std::unique_ptr<service::RecordingPublisher> publisher_;
  std::optional<common::Nanoseconds> first_;
  Clock::time_point start_;
};

bool is_scan(const common::SensorMessage& message) { return std::holds_alternative<common::LaserScan>(message); }

void no_fault(const common::SensorMessage& message, common::Nanoseconds stamp, const Robot::Publish& publish) {
  publish(message, stamp);
}

// What the service says of a topic, and its newest pose.
class Watcher {
 public:
  explicit Watcher(const idl::Participant& participant)
      : diagnostics_([this, &participant](const std::stop_token& done) {
          auto reader =
              idl::Reader<idl::DiagnosticArray>::create(participant, "diagnostics", idl::QosProfile::kTransformInput);
          while (reader && !done.stop_requested()) {
            const auto message = reader->take(50ms);
            if (message && *message) note(***message);
          }
        }),
        poses_([this, &participant](const std::stop_token& done) {
          auto reader = idl::Reader<idl::PoseWithCovarianceStamped>::create(participant, "slamfuse/pose",
                                                                            idl::QosProfile::kTransformInput);
          while (reader && !done.stop_requested()) {
            const auto message = reader->take(50ms);
            if (!message || !*message) continue;
            const auto now = Clock::now();
            const std::lock_guard lock(mutex_);
            newest_pose_ = service::from_ros_time((**message)->header.stamp);
            if (last_pose_) longest_gap_ = std::max(longest_gap_, now - *last_pose_);
            last_pose_ = now;
          }
        }) {}

  // All that was said of the scans since the last call, one line each.
  std::string said() {
    const std::lock_guard lock(mutex_);
    return std::exchange(said_, {});
  }
  common::Nanoseconds newest_pose() {
    const std::lock_guard lock(mutex_);
    return newest_pose_;
  }
  // The longest time [ms] between two poses since the last call.
  double longest_gap_ms() {
    const std::lock_guard lock(mutex_);
    last_pose_.reset();
    return std::chrono::duration<double, std::milli>(std::exchange(longest_gap_, Clock::duration::zero())).count();
  }

 private:
  void note(const idl::DiagnosticArray& message) {
    const std::lock_guard lock(mutex_);
    for (std::uint32_t i = 0; i < message.status._length; ++i) {
      const idl::DiagnosticStatus& status = message.status._buffer[i];
      if (idl::text_of(status.name).ends_with(" scan")) said_ += idl::text_of(status.message) + "\n";
    }
  }

  std::mutex mutex_;
  std::string said_;
  common::Nanoseconds newest_pose_ = 0;
  std::optional<Clock::time_point> last_pose_;
  Clock::duration longest_gap_ = Clock::duration::zero();
  std::jthread diagnostics_;
  std::jthread poses_;
};

TEST(InputFaults, AreDiagnosedAndSurvived) {
  const Network network;
  const auto participant = network.join();
  const fs::path folder = fs::temp_directory_path() / ("slamfuse-faults-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const pid_t service = start({SLAMFUSE_PROGRAM, "serve", "-o", folder / "out", "--modules", "laser"});
  Watcher watcher(participant);
  Robot robot(participant);
  ASSERT_TRUE(robot.wait_for_service());
  std::this_thread::sleep_for(500ms);
  robot.drive(4s, no_fault);
  ASSERT_GT(watcher.newest_pose(), 0);
  EXPECT_THAT(watcher.said(), HasSubstr("ok"));

  // Silence of one second is still usual.
  robot.drive(3500ms, [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    if (!is_scan(message)) publish(message, stamp);
  });
  EXPECT_THAT(watcher.said(), HasSubstr("matched, but silent for"));
  robot.drive(2s, no_fault);
  EXPECT_THAT(watcher.said(), HasSubstr("ok"));

  robot.drive(2s, [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp);
    if (is_scan(message)) publish(message, stamp);
  });
  EXPECT_THAT(watcher.said(), HasSubstr("repeats"));

  std::optional<std::pair<common::SensorMessage, common::Nanoseconds>> held;
  robot.drive(2s, [&held](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    if (is_scan(message) && !held) {
      held = {message, stamp};
      return;
    }
    publish(message, stamp);
    if (!is_scan(message)) return;
    publish(held->first, held->second);
    held.reset();
  });
  EXPECT_THAT(watcher.said(), HasSubstr("steps back"));
  robot.drive(1500ms, no_fault);
  watcher.said();

  const common::Nanoseconds before = watcher.newest_pose();
  robot.drive(
      3s, [](const auto& message, common::Nanoseconds stamp, const auto& publish) { publish(message, stamp + kHour); });
  EXPECT_THAT(watcher.said(), HasSubstr("ahead of all others"));
  EXPECT_GT(watcher.newest_pose(), before + kHour) << "no pose in the new time";

  robot.drive(3s, no_fault);
  EXPECT_THAT(watcher.said(), HasSubstr("steps back"));
  robot.drive(1s, no_fault);
  EXPECT_LT(watcher.newest_pose(), before + kHour / 2) << "no pose in the old time again";
  EXPECT_GT(watcher.newest_pose(), before);

  kill(service, SIGINT);
  EXPECT_EQ(exit_status_of(service), 0);
  fs::remove_all(folder);
}

// A reliable listener that acknowledges nothing any more: its process is stopped, not ended, so that it stays matched
// until its lease ends, ten seconds later.
TEST(InputFaults, AListenerThatHangsHoldsUpNothing) {
  const Network network;
  const auto participant = network.join();
  const fs::path folder = fs::temp_directory_path() / ("slamfuse-hung-" + std::to_string(getpid()));
  fs::create_directories(folder);
  const pid_t service = start(
      {SLAMFUSE_PROGRAM, "serve", "-o", folder / "out", "--modules", "laser", "--set", "service.dds.path_period=0.5"});
  Watcher watcher(participant);
  Robot robot(participant);
  ASSERT_TRUE(robot.wait_for_service());
  const auto ahead = [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp + kHour);
  };
  const pid_t listener = start({SLAMFUSE_PROGRAM, "record", "-o", folder / "bag"});
  robot.drive(6s, ahead);
  std::printf("longest time without a pose: %.0f ms", watcher.longest_gap_ms());
  kill(listener, SIGSTOP);
  robot.drive(4s, ahead);
  std::printf(", with a listener that hangs %.0f ms\n", watcher.longest_gap_ms());
  const common::Nanoseconds before = watcher.newest_pose();
  ASSERT_GT(before, kHour);

  // The clock goes back, so the session ends and another begins, while the listener hangs.
  const auto stepped = Clock::now();
  std::optional<Clock::duration> recovered;
  robot.drive(3s, [&](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp);
    if (!recovered && watcher.newest_pose() < before - kHour / 2) recovered = Clock::now() - stepped;
  });
  EXPECT_TRUE(recovered) << "no pose within 3 s of the step";
  if (recovered) std::printf("poses again %.1f s after the step\n", std::chrono::duration<double>(*recovered).count());

  const auto stopped = Clock::now();
  kill(service, SIGINT);
  EXPECT_EQ(exit_status_of(service), 0);
  std::printf("ended after %.1f s\n", std::chrono::duration<double>(Clock::now() - stopped).count());
  kill(listener, SIGKILL);
  exit_status_of(listener);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace slamfuse::system
