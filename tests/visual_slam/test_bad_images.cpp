// SPDX-License-Identifier: BSD-3-Clause
// Bad pictures and slipping wheels: no crash, no false confidence, recovery.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/recording.hpp"
#include "visual_slam/confidence.hpp"
#include "visual_slam/input_damage.hpp"
#include "visual_slam/visual_slam.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::TrackingState;
using testing::Damage;
using testing::JudgedEstimate;

constexpr double kFrom = 8.0;  // [s] from the recording's start
constexpr double kAfter = 5.0;

struct Outcome {
  std::vector<JudgedEstimate> during;
  std::vector<JudgedEstimate> after;
  std::vector<JudgedEstimate> falsely_confident;
  std::vector<std::string> rejected;

  int count(TrackingState state) const {
    return static_cast<int>(
        std::count_if(during.begin(), during.end(), [state](const auto& e) { return e.state == state; }));
  }
};

/// The demo recording's left camera (or both), damaged for some seconds.
class BadInput : public ::testing::Test {
 protected:
  static Outcome run(Damage damage, double seconds, const std::vector<std::string>& names = {"cam0"},
                     double begin = kFrom) {
    const auto folder = std::filesystem::path(SLAMFUSE_DATA_DIR) / "flat";
    auto recording = common::open_recording(folder);
    const auto truth = common::read_ground_truth(folder);
    if (!recording || !truth) throw std::runtime_error("the demo recording cannot be read");
    const common::Nanoseconds start = (*recording)->info().first_stamp;
    const common::Nanoseconds from = start + common::from_seconds(begin);
    const common::Nanoseconds to = from + common::from_seconds(seconds);
    std::map<std::string, common::CameraCalibration> cameras;
    for (const auto& name : names) cameras.emplace(name, (*recording)->info().calibration.cameras.at(name));
    const auto slam = *VisualSlam::create({}, testing::damaged(damage, cameras), 1, 1);
    testing::Damager damager(damage, from, to);
    Outcome outcome;
    std::vector<common::PoseEstimate> estimates;
    while (true) {
      const auto item = (*recording)->next();
      if (!item || !*item) throw std::runtime_error("the demo recording is too short");
      const auto* message = std::get_if<common::SensorMessage>(&**item);
      if (message == nullptr || !slam->wants(*message)) continue;
      if (common::stamp_of(*message) > to + common::from_seconds(kAfter)) break;
      for (const common::SensorMessage& arriving : damager.apply(*message)) {
        common::ProcessResult result = slam->process(arriving);
        if (result.rejected) outcome.rejected.push_back(*result.rejected);
        if (result.estimate) estimates.push_back(*result.estimate);
      }
    }
    for (const JudgedEstimate& estimate : testing::judge(estimates, *truth, from)) {
      if (testing::is_false_confidence(estimate)) outcome.falsely_confident.push_back(estimate);
      if (estimate.stamp >= from) (estimate.stamp < to ? outcome.during : outcome.after).push_back(estimate);
    }
    return outcome;
  }

  static void expect_never_wrongly_sure(const Outcome& outcome) {
    EXPECT_TRUE(outcome.falsely_confident.empty())
        << outcome.falsely_confident.size() << " poses, the first " << outcome.falsely_confident.front().position
        << " m and " << outcome.falsely_confident.front().heading << " rad off";
  }

  /// Never wrongly sure, and in the end sure and right again.
  static void expect_sound(const Outcome& outcome) {
    expect_never_wrongly_sure(outcome);
    ASSERT_FALSE(outcome.after.empty());
    EXPECT_EQ(outcome.after.back().state, TrackingState::kTracking);
    EXPECT_LT(outcome.after.back().position, testing::kMaxPosition);
    EXPECT_LT(outcome.after.back().heading, testing::kMaxHeading);
  }
};

TEST_F(BadInput, GoodPicturesToCompareWith) {
  const Outcome outcome = run(Damage::kNone, 2.0);
  expect_sound(outcome);
  EXPECT_EQ(outcome.count(TrackingState::kTracking), static_cast<int>(outcome.during.size()));
}

TEST_F(BadInput, BlackPictures) {
  const Outcome outcome = run(Damage::kBlack, 4.0);
  expect_sound(outcome);
  EXPECT_EQ(outcome.during.back().state, TrackingState::kLost);
}

TEST_F(BadInput, WhitePictures) {
  const Outcome outcome = run(Damage::kWhite, 4.0);
  expect_sound(outcome);
  EXPECT_EQ(outcome.during.back().state, TrackingState::kLost);
}

TEST_F(BadInput, OverExposedPictures) { expect_sound(run(Damage::kOverExposed, 3.0)); }

TEST_F(BadInput, BlurredPictures) { expect_sound(run(Damage::kBlurred, 3.0)); }

TEST_F(BadInput, ACameraCoveredForTenSeconds) {
  const Outcome outcome = run(Damage::kCovered, 10.0);
  expect_sound(outcome);
  EXPECT_EQ(outcome.during.back().state, TrackingState::kLost);
}

TEST_F(BadInput, FrozenPictures) {
  const Outcome outcome = run(Damage::kFrozen, 4.0);
  expect_sound(outcome);
  EXPECT_EQ(outcome.during.back().state, TrackingState::kLost);
}

TEST_F(BadInput, DroppedPictures) {
  const Outcome outcome = run(Damage::kDropped, 4.0);
  expect_sound(outcome);
  EXPECT_TRUE(outcome.during.empty()) << "without an image there is no estimate";
}

TEST_F(BadInput, PicturesOutOfOrder) {
  const Outcome outcome = run(Damage::kOutOfOrder, 3.0);
  expect_sound(outcome);
  ASSERT_FALSE(outcome.rejected.empty());
  EXPECT_NE(outcome.rejected.front().find("is not after"), std::string::npos);
  EXPECT_EQ(outcome.count(TrackingState::kTracking), static_cast<int>(outcome.during.size()));
}

TEST_F(BadInput, PicturesOfTheWrongSize) {
  const Outcome outcome = run(Damage::kWrongSize, 3.0);
  expect_sound(outcome);
  ASSERT_FALSE(outcome.rejected.empty());
  EXPECT_NE(outcome.rejected.front().find("320 x 240"), std::string::npos);
}

// What was seen before the slip does not come back into view in these seconds: the pose is right, and UNCERTAIN.
TEST_F(BadInput, WheelsThatSlip) {
  for (const std::vector<std::string>& cameras : {std::vector<std::string>{"cam0"}, {"cam0", "cam1"}}) {
    const Outcome outcome = run(Damage::kWheelSlip, 5.0, cameras);
    expect_never_wrongly_sure(outcome);
    EXPECT_EQ(outcome.count(TrackingState::kLost), 0);
    EXPECT_LT(outcome.after.back().position, 2.0 * testing::kMaxPosition);
  }
}

// From 40 s on the robot turns by 0.1 deg in 5 s.
TEST_F(BadInput, WheelsThatSlipOnAStraightWay) {
  const Outcome outcome = run(Damage::kWheelSlip, 5.0, {"cam0", "cam1"}, 40.0);
  expect_sound(outcome);
  EXPECT_GT(2 * outcome.count(TrackingState::kUncertain), static_cast<int>(outcome.during.size()));
  EXPECT_EQ(outcome.count(TrackingState::kLost), 0);
}

// One camera alone bends map and odometry to agree with a wrong focal length; see visual_slam/README.md.
TEST_F(BadInput, WrongIntrinsics) {
  const Outcome outcome = run(Damage::kWrongIntrinsics, 5.0, {"cam0", "cam1"});
  expect_never_wrongly_sure(outcome);
  EXPECT_EQ(outcome.after.back().state, TrackingState::kUncertain) << "they stay wrong";
}

}  // namespace
}  // namespace slamfuse::visual_slam
