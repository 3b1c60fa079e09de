// SPDX-License-Identifier: BSD-3-Clause
// What a robot's inputs may do to `slamfuse serve`: silence, doubled and swapped messages, a clock that jumps an hour
// ahead and back, ten times and a tenth of the rate, a camera_info that is missing or changes. Each has its diagnosis
// within 2 s, and poses come again within 3 s.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/replay.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"
#include "service/recording_publisher.hpp"
#include "service/ros_conversion.hpp"
#include "service/sensor_to_ros.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using testing::HasSubstr;

constexpr common::Nanoseconds kHour = 3600 * common::kNanosecondsPerSecond;

// The laser and the odometry of the demo recording in real time, and the pictures of its first camera for those who
// want to publish them, as a fault lets them through.
class Robot {
 public:
  // Publishes a message with this stamp.
  using Publish = std::function<void(const common::SensorMessage&, common::Nanoseconds)>;
  using Fault = std::function<void(const common::SensorMessage&, common::Nanoseconds, const Publish&)>;

  explicit Robot(const idl::Participant& participant)
      : recording_(*common::replay(*common::open_recording(SLAMFUSE_DATA_DIR "/flat"), used_sensors())),
        publisher_(*service::RecordingPublisher::create(participant, without_cameras(recording_->info()))),
        start_(Clock::now()) {}

  const common::CameraCalibration& camera() const { return recording_->info().calibration.cameras.at("cam0"); }

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
      fault(*message, stamp, [this](const auto& sent, common::Nanoseconds as) {
        if (!std::holds_alternative<common::Image>(sent)) publisher_->publish(sent, as);
      });
    }
  }

 private:
  static common::ReplayOptions used_sensors() {
    common::ReplayOptions options;
    options.only_sensors = {"laser0", "odom0", "cam0"};
    return options;
  }

  // Where they are mounted is told all the same.
  static common::RecordingInfo without_cameras(common::RecordingInfo info) {
    std::erase_if(info.sensors, [](const auto& sensor) { return sensor.second.kind == common::SensorKind::kCamera; });
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

// The first camera's pictures, with or without its calibration.
class Camera {
 public:
  explicit Camera(const idl::Participant& participant)
      : images_(idl::Writer<idl::Image>::create(participant, "cam0/image_raw", idl::QosProfile::kOutput).value()),
        infos_(
            idl::Writer<idl::CameraInfo>::create(participant, "cam0/camera_info", idl::QosProfile::kOutput).value()) {}

  // Publishes a message if it is a picture, and beside it this calibration, if any.
  void publish(const common::SensorMessage& message, const std::optional<common::CameraCalibration>& calibration) {
    const auto* image = std::get_if<common::Image>(&message);
    if (image == nullptr) return;
    const service::RosHeader header{image->stamp, "cam0"};
    if (calibration) infos_.write(service::to_ros_camera_info(header, *calibration));
    images_.write(service::to_ros_image(header, *image));
  }

 private:
  idl::Writer<idl::Image> images_;
  idl::Writer<idl::CameraInfo> infos_;
};

// What the service says of its topics, and its newest pose.
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
            const idl::Point& at = (**message)->pose.pose.position;
            if (position_)
              farthest_step_ = std::max(farthest_step_, std::hypot(at.x - position_->x, at.y - position_->y));
            position_ = at;
            if (last_pose_) longest_gap_ = std::max(longest_gap_, now - *last_pose_);
            last_pose_ = now;
          }
        }) {}

  // All that was said of a topic since the last forget(), one line each.
  std::string said(const std::string& topic = "scan") {
    const std::lock_guard lock(mutex_);
    return said_[topic];
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    said_.clear();
  }
  // The farthest way [m] from one pose to the next since the last call.
  double farthest_step() {
    const std::lock_guard lock(mutex_);
    return std::exchange(farthest_step_, 0.0);
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
      const std::string name = idl::text_of(status.name);
      said_[name.substr(name.rfind(' ') + 1)] += idl::text_of(status.message) + "\n";
    }
  }

  std::mutex mutex_;
  std::map<std::string, std::string> said_;  // by topic
  std::optional<idl::Point> position_;
  double farthest_step_ = 0.0;
  common::Nanoseconds newest_pose_ = 0;
  std::optional<Clock::time_point> last_pose_;
  Clock::duration longest_gap_ = Clock::duration::zero();
  std::jthread diagnostics_;
  std::jthread poses_;
};

// A robot before a service that is watched.
class InputFaults : public testing::Test {
 protected:
  ~InputFaults() override {
    if (service_ != 0) {  // a test gave up
      kill(service_, SIGKILL);
      exit_status_of(service_);
    }
    fs::remove_all(folder_);
  }

  // Starts `slamfuse serve` with these arguments more and waits until it listens.
  void serve(const std::vector<std::string>& arguments) {
    fs::create_directories(folder_);
    std::vector<std::string> words{SLAMFUSE_PROGRAM, "serve", "-o", folder_ / "out"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    service_ = start(words);
    ASSERT_TRUE(robot_.wait_for_service());
    std::this_thread::sleep_for(500ms);
  }

  void end_service() {
    kill(service_, SIGINT);
    EXPECT_EQ(exit_status_of(std::exchange(service_, 0)), 0);
  }

  Network network_;
  idl::Participant participant_ = network_.join();
  fs::path folder_ = fs::temp_directory_path() / ("slamfuse-faults-" + std::to_string(getpid()));
  Watcher watcher_{participant_};
  Robot robot_{participant_};
  pid_t service_ = 0;
};

// The robot with its first camera, which tells what is `told_` of its calibration.
class CameraFaults : public InputFaults {
 protected:
  void drive(std::chrono::milliseconds duration) {
    robot_.drive(duration, [this](const auto& message, common::Nanoseconds stamp, const auto& publish) {
      publish(message, stamp);
      camera_.publish(message, told_);
    });
  }

  // Drives on until the service says something of the pictures; gives the time it took [s].
  double drive_until_said(const std::string& words) {
    watcher_.forget();
    const auto start = Clock::now();
    while (Clock::now() - start < 5s) {
      drive(100ms);
      if (watcher_.said(kPictures).find(words) != std::string::npos) break;
    }
    return std::chrono::duration<double>(Clock::now() - start).count();
  }

  const std::string kPictures = "cam0/image_raw";
  Camera camera_{participant_};
  std::optional<common::CameraCalibration> told_;
};

TEST_F(InputFaults, AreDiagnosedAndSurvived) {
  serve({"--modules", "laser"});
  robot_.drive(4s, no_fault);
  ASSERT_GT(watcher_.newest_pose(), 0);
  EXPECT_THAT(watcher_.said(), HasSubstr("ok"));
  watcher_.forget();

  // Silence of one second is still usual.
  robot_.drive(3500ms, [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    if (!is_scan(message)) publish(message, stamp);
  });
  EXPECT_THAT(watcher_.said(), HasSubstr("matched, but silent for"));
  watcher_.forget();
  robot_.drive(2s, no_fault);
  EXPECT_THAT(watcher_.said(), HasSubstr("ok"));
  watcher_.forget();

  robot_.drive(2s, [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp);
    if (is_scan(message)) publish(message, stamp);
  });
  EXPECT_THAT(watcher_.said(), HasSubstr("repeats"));
  watcher_.forget();

  std::optional<std::pair<common::SensorMessage, common::Nanoseconds>> held;
  robot_.drive(2s, [&held](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    if (is_scan(message) && !held) {
      held = {message, stamp};
      return;
    }
    publish(message, stamp);
    if (!is_scan(message)) return;
    publish(held->first, held->second);
    held.reset();
  });
  EXPECT_THAT(watcher_.said(), HasSubstr("steps back"));
  watcher_.forget();
  robot_.drive(1500ms, no_fault);
  watcher_.forget();

  const common::Nanoseconds before = watcher_.newest_pose();
  robot_.drive(
      3s, [](const auto& message, common::Nanoseconds stamp, const auto& publish) { publish(message, stamp + kHour); });
  EXPECT_THAT(watcher_.said(), HasSubstr("ahead of all others"));
  watcher_.forget();
  EXPECT_GT(watcher_.newest_pose(), before + kHour) << "no pose in the new time";

  robot_.drive(3s, no_fault);
  EXPECT_THAT(watcher_.said(), HasSubstr("steps back"));
  watcher_.forget();
  robot_.drive(1s, no_fault);
  EXPECT_LT(watcher_.newest_pose(), before + kHour / 2) << "no pose in the old time again";
  EXPECT_GT(watcher_.newest_pose(), before);

  end_service();
}

// A usual rate is known after some seconds.
TEST_F(InputFaults, AnotherRateIsDiagnosedAndSurvived) {
  serve({"--modules", "laser"});
  robot_.drive(8s, no_fault);
  EXPECT_THAT(watcher_.said(), HasSubstr("ok"));
  watcher_.longest_gap_ms();

  // Ten times the scans: each once more in every tenth of the time to the next.
  constexpr common::Nanoseconds kTenth = 16'000'000;
  watcher_.forget();
  robot_.drive(3s, [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    for (int i = 0; i < (is_scan(message) ? 10 : 1); ++i) publish(message, stamp + i * kTenth);
  });
  EXPECT_THAT(watcher_.said(), testing::ContainsRegex("usual are [567]\\.[0-9]"));
  std::printf("ten times the rate: longest time without a pose %.0f ms\n", watcher_.longest_gap_ms());
  robot_.drive(2s, no_fault);
  watcher_.forget();
  robot_.drive(1500ms, no_fault);
  EXPECT_THAT(watcher_.said(), HasSubstr("ok"));

  int scans = 0;
  watcher_.forget();
  watcher_.longest_gap_ms();
  robot_.drive(4s, [&scans](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    if (!is_scan(message) || scans++ % 10 == 0) publish(message, stamp);
  });
  EXPECT_THAT(watcher_.said(), testing::ContainsRegex("usual are [567]\\.[0-9]"));
  const double gap = watcher_.longest_gap_ms();
  EXPECT_LT(gap, 3000.0);
  std::printf("a tenth of the rate: longest time without a pose %.0f ms\n", gap);
  robot_.drive(2s, no_fault);
  watcher_.forget();
  robot_.drive(1500ms, no_fault);
  EXPECT_THAT(watcher_.said(), HasSubstr("ok"));

  end_service();
}

TEST_F(CameraFaults, ACameraWhoseCalibrationComesLateOrChangesIsDiagnosedAndUsed) {
  serve({});
  drive(2s);
  EXPECT_THAT(watcher_.said(kPictures), HasSubstr("cannot be used: no camera_info was heard of it"));
  drive(4s);
  ASSERT_GT(watcher_.newest_pose(), 0) << "the laser half needs no camera";

  // The calibration comes: a new session with the camera, in the map made so far.
  const common::CameraCalibration right = robot_.camera();
  watcher_.longest_gap_ms();
  watcher_.farthest_step();
  told_ = right;
  EXPECT_LT(drive_until_said("ok"), 3.0);
  drive(3s);
  EXPECT_THAT(watcher_.said(kPictures), testing::Not(HasSubstr("cannot be used")));
  double gap = watcher_.longest_gap_ms();
  EXPECT_LT(gap, 3000.0);
  EXPECT_LT(watcher_.farthest_step(), 0.5 + 1e-3 * gap) << "the map is not the one made so far";
  std::printf("the calibration comes: longest time without a pose %.0f ms\n", gap);

  // For a moment another one: pictures are not used, nothing else happens.
  common::CameraCalibration wrong = right;
  wrong.fx *= 1.2;
  told_ = wrong;
  drive(600ms);
  told_ = right;
  EXPECT_LT(drive_until_said("tells another calibration"), 2.0);
  drive(2s);
  EXPECT_LT(watcher_.longest_gap_ms(), 500.0);
  EXPECT_LT(drive_until_said("ok"), 2.0);

  // It stays: a new session with it.
  told_ = wrong;
  EXPECT_LT(drive_until_said("tells another calibration"), 2.0);
  EXPECT_LT(drive_until_said("ok"), 3.0);
  drive(3s);
  gap = watcher_.longest_gap_ms();
  EXPECT_LT(gap, 3000.0);
  EXPECT_LT(watcher_.farthest_step(), 0.5 + 1e-3 * gap);
  std::printf("the calibration changes: longest time without a pose %.0f ms\n", gap);

  end_service();
}

TEST_F(CameraFaults, WhoAsksForTheCamerasWaitsForTheirCalibration) {
  serve({"--modules", "laser,visual"});
  drive(3s);
  EXPECT_THAT(watcher_.said(kPictures), HasSubstr("cannot be used: no camera_info was heard of it"));
  EXPECT_EQ(watcher_.newest_pose(), 0) << "it began with half of what it was asked for";
  told_ = robot_.camera();
  drive(3s);
  EXPECT_GT(watcher_.newest_pose(), 0);

  end_service();
}

// A reliable listener that acknowledges nothing any more: its process is stopped, not ended, so that it stays matched
// until its lease ends, ten seconds later.
TEST_F(InputFaults, AListenerThatHangsHoldsUpNothing) {
  serve({"--modules", "laser", "--set", "service.dds.path_period=0.5"});
  const auto ahead = [](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp + kHour);
  };
  const pid_t listener = start({SLAMFUSE_PROGRAM, "record", "-o", folder_ / "bag"});
  robot_.drive(6s, ahead);
  std::printf("longest time without a pose: %.0f ms", watcher_.longest_gap_ms());
  kill(listener, SIGSTOP);
  robot_.drive(4s, ahead);
  std::printf(", with a listener that hangs %.0f ms\n", watcher_.longest_gap_ms());
  const common::Nanoseconds before = watcher_.newest_pose();
  ASSERT_GT(before, kHour);

  // The clock goes back, so the session ends and another begins, while the listener hangs.
  const auto stepped = Clock::now();
  std::optional<Clock::duration> recovered;
  robot_.drive(3s, [&](const auto& message, common::Nanoseconds stamp, const auto& publish) {
    publish(message, stamp);
    if (!recovered && watcher_.newest_pose() < before - kHour / 2) recovered = Clock::now() - stepped;
  });
  EXPECT_TRUE(recovered) << "no pose within 3 s of the step";
  if (recovered) std::printf("poses again %.1f s after the step\n", std::chrono::duration<double>(*recovered).count());

  const auto stopped = Clock::now();
  end_service();
  std::printf("ended after %.1f s\n", std::chrono::duration<double>(Clock::now() - stopped).count());
  kill(listener, SIGKILL);
  exit_status_of(listener);
}

}  // namespace
}  // namespace slamfuse::system
