// SPDX-License-Identifier: BSD-3-Clause
#include "service/live_source.hpp"

#include <functional>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/writer.hpp"
#include "service/sensor_to_ros.hpp"
#include "service/three_beams.hpp"
#include "system/network.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr common::Nanoseconds kStamp = 1'700'000'000'000'000'000;
constexpr common::Nanoseconds kPeriod = 20'000'000;

// A robot with one laser and one camera, of which every message has a later stamp.
class Robot {
 public:
  explicit Robot(const idl::Participant& participant)
      : scans_(writer<idl::LaserScan>(participant, "scan", idl::QosProfile::kOutput)),
        images_(writer<idl::Image>(participant, "cam0/image_raw", idl::QosProfile::kOutput)),
        infos_(writer<idl::CameraInfo>(participant, "cam0/camera_info", idl::QosProfile::kOutput)),
        mountings_(writer<idl::TFMessage>(participant, "tf_static", idl::QosProfile::kLatchedOutput)) {}

  void scan(const std::string& frame) {
    ASSERT_TRUE(scans_.wait_for_reader(10s));
    scans_.write(to_ros_scan({stamp_ += kPeriod, frame}, {stamp_, "laser0", {1.0F, 2.0F, 3.0F}}, three_beams()));
  }
  void image() {
    ASSERT_TRUE(images_.wait_for_reader(10s));
    images_.write(to_ros_image({stamp_ += kPeriod, "base_link"},
                               {stamp_, "cam0", 4, 3, std::make_shared<const std::vector<std::uint8_t>>(12, 100)}));
  }
  void camera_info(double focal_length) {
    common::CameraCalibration camera;
    camera.width = 4;
    camera.height = 3;
    camera.fx = camera.fy = focal_length;
    ASSERT_TRUE(infos_.wait_for_reader(10s));
    infos_.write(to_ros_camera_info({stamp_, "base_link"}, camera));
  }
  void mount(const std::string& frame) {
    ASSERT_TRUE(mountings_.wait_for_reader(10s));
    mountings_.write(to_ros_transforms({stamp_, "base_link"}, {{frame, common::to_pose3({0.2, 0.0, 0.0})}}));
  }

 private:
  template <class T>
  static idl::Writer<T> writer(const idl::Participant& participant, const std::string& topic, idl::QosProfile profile) {
    return idl::Writer<T>::create(participant, topic, profile).value();
  }

  common::Nanoseconds stamp_ = kStamp;
  idl::Writer<idl::LaserScan> scans_;
  idl::Writer<idl::Image> images_;
  idl::Writer<idl::CameraInfo> infos_;
  idl::Writer<idl::TFMessage> mountings_;
};

class LiveSourceTest : public testing::Test {
 protected:
  void listen(std::map<std::string, std::string> topics) {
    LiveSourceOptions options;
    options.inbox.topics = std::move(topics);
    source_ = *LiveSource::create(participant_, options, stop_);
  }
  void prepare() {
    ASSERT_TRUE(source_->prepare([](const std::string&) {}));
  }
  // Takes what comes while the robot goes on doing this, to the end of the session.
  void drive_to_the_end(const std::function<void()>& publish) {
    const std::jthread robot([&](const std::stop_token& done) {
      while (!done.stop_requested()) {
        publish();
        std::this_thread::sleep_for(20ms);
      }
    });
    while (*source_->next()) continue;
  }
  InputState state_of(const std::string& topic) const {
    for (const InputState& state : source_->inputs()) {
      if (state.topic == topic) return state;
    }
    return {};
  }

  system::Network network_;
  idl::Participant participant_ = network_.join();
  Robot robot_{participant_};
  std::atomic<bool> stop_{false};
  std::unique_ptr<LiveSource> source_;
  // Whatever goes wrong, no test waits for ever.
  std::jthread watchdog_{[this](const std::stop_token& done) {
    for (int i = 0; i < 300 && !done.stop_requested(); ++i) std::this_thread::sleep_for(100ms);
    stop_ = true;
  }};
};

TEST_F(LiveSourceTest, ARequestThatComesWhileASessionEndsIsMetByItsEnd) {
  listen({{"laser0", "scan"}});
  robot_.scan("base_link");
  prepare();
  ASSERT_TRUE(*source_->next());
  source_->end_session("the first reason");
  EXPECT_FALSE(*source_->next());
  source_->end_session("another reason");
  EXPECT_EQ(source_->restart_wanted(), "the first reason");
  robot_.scan("base_link");
  EXPECT_TRUE(*source_->next()) << "the next session was ended too";
}

TEST_F(LiveSourceTest, WaitsForTheTransformOfASensor) {
  listen({{"laser0", "scan"}});
  robot_.scan("front");
  const std::jthread late([this] {
    std::this_thread::sleep_for(1s);
    robot_.mount("front");
  });
  prepare();
  EXPECT_TRUE(source_->info().notes.empty());
  EXPECT_NEAR(source_->info().calibration.lasers.at("laser0").T_base_laser.translation.x(), 0.2, 1e-12);
}

TEST_F(LiveSourceTest, ATransformThatComesTooLateIsToldAndNotUsed) {
  listen({{"laser0", "scan"}});
  robot_.scan("front");
  prepare();
  EXPECT_THAT(source_->info().notes, ElementsAre(HasSubstr("no transform between base_link and front")));
  robot_.mount("front");
  drive_to_the_end([this] {
    robot_.scan("front");
    if (!state_of("scan").problem.empty()) source_->end_session("a reason");
  });
  EXPECT_THAT(state_of("scan").problem, HasSubstr("came too late"));
  ASSERT_TRUE(source_->restart_wanted());
  EXPECT_NEAR(source_->info().calibration.lasers.at("laser0").T_base_laser.translation.norm(), 0.0, 1e-12);
  EXPECT_THAT(source_->info().notes, ElementsAre(HasSubstr("came too late")));
}

// A camera may tell its new calibration once, just before a session ends for another reason.
TEST_F(LiveSourceTest, ADoubtAboutACalibrationOutlastsTheSession) {
  listen({{"cam0", "cam0/image_raw"}});
  robot_.camera_info(2.0);
  robot_.image();
  prepare();
  ASSERT_TRUE(*source_->next());
  robot_.camera_info(3.0);
  drive_to_the_end([this] {
    robot_.image();
    if (state_of("cam0/image_raw").rejected > 0) source_->end_session("another reason");
  });
  EXPECT_EQ(source_->restart_wanted(), "another reason");
  EXPECT_EQ(source_->info().calibration.cameras.at("cam0").fx, 2.0);
  drive_to_the_end([this] { robot_.image(); });
  EXPECT_EQ(source_->restart_wanted(), "the calibration of cam0 changed");
  EXPECT_EQ(source_->info().calibration.cameras.at("cam0").fx, 3.0);
}

}  // namespace
}  // namespace slamfuse::service
