// SPDX-License-Identifier: BSD-3-Clause
#include "common/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A recording of odom0 at 0, 100, ... 900 ms and laser0 at 50, 250, ... 850 ms; a rejected message of laser0 at 450
/// ms.
class MadeUpRecording final : public Recording {
 public:
  explicit MadeUpRecording(double angle_min = -1.0) {
    info_.sensors["odom0"] = {SensorKind::kOdometry, 10, ms(0), ms(900)};
    info_.sensors["laser0"] = {SensorKind::kLaser, 5, ms(50), ms(850)};
    LaserCalibration& laser = info_.calibration.lasers["laser0"];
    laser.angle_min = angle_min;
    laser.angle_increment = 0.5;
    laser.beams = 3;
    info_.first_stamp = ms(0);
    info_.last_stamp = ms(900);
    for (int t = 0; t < 1000; t += 50) {
      if (t % 100 == 0) items_.emplace_back(WheelOdometry{ms(t), "odom0", {}, 0, 0});
      if (t == 450) items_.emplace_back(RejectedMessage{ms(t), "laser0", "made up"});
      if (t % 200 == 50 && t != 450) items_.emplace_back(LaserScan{ms(t), "laser0", {1.0F, 2.0F, 3.0F}});
    }
  }
  static Nanoseconds ms(int t) { return kSampleStart + Nanoseconds{t} * 1'000'000; }
  const RecordingInfo& info() const override { return info_; }
  Result<std::optional<RecordingItem>> next() override {
    if (at_ == items_.size()) return std::nullopt;
    return items_[at_++];
  }

 private:
  RecordingInfo info_;
  std::vector<RecordingItem> items_;
  std::size_t at_ = 0;
};

/// What a replay gives as "o0 l50 x450 ...": kind and milliseconds since the start.
std::vector<std::string> played(const ReplayOptions& options) {
  const auto recording = replay(std::make_unique<MadeUpRecording>(), options);
  EXPECT_TRUE(recording) << recording.error().message;
  std::vector<std::string> result;
  while (recording) {
    const auto item = (*recording)->next();
    if (!item || !*item) break;
    const auto* rejected = std::get_if<RejectedMessage>(&**item);
    const Nanoseconds stamp = rejected ? rejected->stamp : stamp_of(std::get<SensorMessage>(**item));
    const std::string kind = rejected ? "x" : sensor_of(std::get<SensorMessage>(**item)).substr(0, 1);
    result.push_back(kind + std::to_string((stamp - kSampleStart) / 1'000'000));
  }
  return result;
}

TEST(Replay, LeavesOutTheSensorsThatNobodyListensTo) {
  ReplayOptions options;
  options.to = 0.5;
  options.only_sensors = {"odom0"};
  EXPECT_THAT(played(options), ElementsAre("o0", "o100", "o200", "o300", "o400", "o500"));
  options.only_sensors = {"laser0"};
  EXPECT_THAT(played(options), ElementsAre("l50", "l250", "x450"));
}

TEST(Replay, ChangesNothingWithoutOptions) {
  EXPECT_THAT(played({}), ElementsAre("o0", "l50", "o100", "o200", "l250", "o300", "o400", "x450", "o500", "o600",
                                      "l650", "o700", "o800", "l850", "o900"));
}

TEST(Replay, KeepsOnlyTheTimeWindow) {
  ReplayOptions options;
  options.from = 0.25;
  options.to = 0.5;
  EXPECT_THAT(played(options), ElementsAre("l250", "o300", "o400", "x450", "o500"));
}

TEST(Replay, DeliversASensorLateWithTrueStamps) {
  ReplayOptions options;
  options.arrival_delay["laser0"] = 0.2;
  EXPECT_THAT(played(options), ElementsAre("o0", "o100", "o200", "l50", "o300", "o400", "l250", "o500", "o600", "x450",
                                           "o700", "o800", "l650", "o900", "l850"));
}

TEST(Replay, KeepsTheOriginalOrderOfMessagesThatArriveTogether) {
  ReplayOptions options;
  options.arrival_delay["laser0"] = 0.05;
  const std::vector<std::string> order = played(options);
  // The scan of 50 ms arrives at 100 ms, together with the odometry of 100 ms, and was recorded before it.
  EXPECT_LT(std::find(order.begin(), order.end(), "l50"), std::find(order.begin(), order.end(), "o100"));
}

TEST(Replay, FalsifiesStampsWithoutChangingTheOrder) {
  ReplayOptions options;
  options.stamp_offset["laser0"] = -0.12;
  EXPECT_THAT(played(options), ElementsAre("o0", "l-70", "o100", "o200", "l130", "o300", "o400", "x330", "o500", "o600",
                                           "l530", "o700", "o800", "l730", "o900"));
}

TEST(Replay, TellsTheTimesItPlays) {
  ReplayOptions options;
  options.from = 0.2;
  options.to = 0.6;
  options.stamp_offset["laser0"] = 0.3;
  const auto recording = replay(std::make_unique<MadeUpRecording>(), options);
  ASSERT_TRUE(recording);
  EXPECT_EQ((*recording)->info().first_stamp, MadeUpRecording::ms(200));
  EXPECT_EQ((*recording)->info().last_stamp, MadeUpRecording::ms(900));
  EXPECT_EQ((*recording)->info().sensors.at("laser0").first_stamp, MadeUpRecording::ms(500));
}

TEST(Replay, RefusesAnUnknownSensorAndNamesThoseThereAre) {
  for (const bool delay : {true, false}) {
    ReplayOptions options;
    (delay ? options.arrival_delay : options.stamp_offset)["cam7"] = 0.1;
    const auto recording = replay(std::make_unique<MadeUpRecording>(), options);
    ASSERT_FALSE(recording);
    EXPECT_EQ(recording.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(recording.error().message, AllOf(HasSubstr("cam7"), HasSubstr("laser0, odom0")));
  }
}

TEST(Replay, RefusesTimesThatMakeNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<ReplayOptions> cases(8);
  cases[0].from = -1.0;
  cases[1].from = nan;
  cases[2].to = 0.0;
  cases[3].to = nan;
  cases[4].arrival_delay["odom0"] = -0.1;
  cases[5].arrival_delay["odom0"] = 1e9;
  cases[6].stamp_offset["odom0"] = nan;
  cases[7].from = 5.0;  // behind the end
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto recording = replay(std::make_unique<MadeUpRecording>(), cases[i]);
    ASSERT_FALSE(recording) << i;
    EXPECT_EQ(recording.error().kind, ErrorKind::kUsage) << i;
  }
}

TEST(Replay, SetsHowLongASweepTakesAndWhichBeamIsFirst) {
  ReplayOptions options;
  options.sweep_duration["laser0"] = 0.1;
  options.only_sensors = {"laser0"};
  const auto forward = replay(std::make_unique<MadeUpRecording>(), options);
  ASSERT_TRUE(forward);
  EXPECT_EQ((*forward)->info().calibration.lasers.at("laser0").sweep_duration, 0.1);
  EXPECT_EQ((*forward)->info().calibration.lasers.at("laser0").angle_min, -1.0);

  options.sweep_duration["laser0"] = -0.1;
  const auto backward = replay(std::make_unique<MadeUpRecording>(), options);
  ASSERT_TRUE(backward);
  const LaserCalibration& laser = (*backward)->info().calibration.lasers.at("laser0");
  EXPECT_EQ(laser.sweep_duration, 0.1);
  EXPECT_EQ(laser.angle_min, 0.0);
  EXPECT_EQ(laser.angle_increment, -0.5);
  const auto item = (*backward)->next();
  ASSERT_TRUE(item && *item);
  EXPECT_THAT(std::get<LaserScan>(std::get<SensorMessage>(**item)).ranges, ElementsAre(3.0F, 2.0F, 1.0F));

  const auto wide = replay(std::make_unique<MadeUpRecording>(6.0), options);
  ASSERT_TRUE(wide);
  EXPECT_NEAR((*wide)->info().calibration.lasers.at("laser0").angle_min, 7.0 - 2.0 * std::numbers::pi, 1e-12)
      << "bearings stay within a turn";

  options.sweep_duration = {{"odom0", 0.1}};
  EXPECT_THAT(replay(std::make_unique<MadeUpRecording>(), options).error().message, HasSubstr("odom0 is no laser"));
  options.sweep_duration = {{"laser0", -61.0}};
  EXPECT_THAT(replay(std::make_unique<MadeUpRecording>(), options).error().message, HasSubstr("--sweep-duration"));
}

}  // namespace
}  // namespace slamfuse::common
