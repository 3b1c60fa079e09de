// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/carry_watch.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

using common::PoseSource;
using common::TrackingState;

const common::Pose2 kHere{0.01, 0.0, 0.0};
const common::Pose2 kElsewhere{4.0, 0.0, 0.0};

/// A watch and the halves' monitors, told together as the fusion tells them.
class Halves {
 public:
  explicit Halves(const SupervisionOptions& options = {}) : watch(options, 1.0) {}

  /// A half says something of itself; `off` and `used` of a pose that was measured.
  void say(PoseSource source, double time, TrackingState state, const common::Pose2& off = kHere, bool used = true,
           std::optional<int> inliers = std::nullopt) {
    now = common::from_seconds(time);
    common::PoseEstimate estimate;
    estimate.stamp = now;
    estimate.source = source;
    estimate.state = state;
    estimate.health.inliers = inliers;
    watch.estimated(estimate, now, monitors.at(source), true);
    monitors.at(source).estimated(estimate);
    if (state == TrackingState::kLost) return;
    MeasurementReport report;
    report.outcome = used ? MeasurementOutcome::kFused : MeasurementOutcome::kGated;
    monitors.at(source).measured(report);
    watch.measured(estimate, off, used);
  }
  Verdict verdict() const {
    StatusEntry entry;
    watch.judge(monitors, now, entry);
    return entry.state;
  }
  bool carried() const { return watch.carried(monitors, now); }

  SourceMonitors monitors{{PoseSource::kLaser, SourceMonitor(PoseSource::kLaser, {})},
                          {PoseSource::kVisual, SourceMonitor(PoseSource::kVisual, {})}};
  CarryWatch watch;
  common::Nanoseconds now = 0;
};

void track(Halves& halves, double until) {
  for (double time = 0.0; time < until; time += 0.25) {
    halves.say(PoseSource::kLaser, time, TrackingState::kTracking);
    halves.say(PoseSource::kVisual, time, TrackingState::kTracking);
  }
}

TEST(CarryWatch, HasNothingAgainstHalvesThatTrack) {
  Halves halves;

  track(halves, 5.0);

  EXPECT_EQ(halves.verdict(), Verdict::kTracking);
  EXPECT_FALSE(halves.carried());
}

TEST(CarryWatch, DoubtsUntilTheOtherHalfHasConfirmedForAMoment) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kVisual, 2.0, TrackingState::kUncertain);
  EXPECT_EQ(halves.verdict(), Verdict::kSuspect);

  halves.say(PoseSource::kLaser, 2.5, TrackingState::kTracking);
  EXPECT_EQ(halves.verdict(), Verdict::kSuspect);
  halves.say(PoseSource::kVisual, 2.6, TrackingState::kUncertain);
  halves.say(PoseSource::kLaser, 3.1, TrackingState::kTracking);

  EXPECT_EQ(halves.verdict(), Verdict::kTracking);
}

TEST(CarryWatch, ACameraThatRanOutOfFeaturesWasNotCarried) {
  Halves blank;
  Halves carried;
  track(blank, 2.0);
  track(carried, 2.0);
  for (int n = 0; n < 5; ++n) {
    blank.say(PoseSource::kVisual, 2.0 + 0.2 * n, TrackingState::kTracking, kHere, true, 20 - 4 * n);
    carried.say(PoseSource::kVisual, 2.0 + 0.2 * n, TrackingState::kTracking, kHere, true, 20);
  }

  blank.say(PoseSource::kVisual, 3.0, TrackingState::kTracking, kHere, true, 3);
  blank.say(PoseSource::kVisual, 3.2, TrackingState::kUncertain, kHere, true, 0);
  carried.say(PoseSource::kVisual, 3.0, TrackingState::kTracking, kHere, true, 0);
  carried.say(PoseSource::kVisual, 3.2, TrackingState::kUncertain, kHere, true, 0);

  EXPECT_EQ(blank.verdict(), Verdict::kTracking);
  EXPECT_EQ(carried.verdict(), Verdict::kSuspect);
}

TEST(CarryWatch, PicturesWithManyFeaturesVouchSooner) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);

  halves.say(PoseSource::kVisual, 2.6, TrackingState::kTracking, kHere, true, 30);

  EXPECT_EQ(halves.verdict(), Verdict::kTracking);
}

/// Fed another place's scans the laser is lost, and then tells nonsense.
TEST(CarryWatch, WhatAHalfSaysAfterTheOtherHasVouchedIsNoCarry) {
  Halves halves;
  track(halves, 2.0);
  for (double time = 2.0; time < 4.0; time += 0.25) {
    halves.say(PoseSource::kLaser, time, TrackingState::kLost);
    halves.say(PoseSource::kVisual, time + 0.1, TrackingState::kTracking, kHere, true, 30);
  }
  halves.say(PoseSource::kLaser, 4.0, TrackingState::kTracking, kElsewhere, false);
  halves.say(PoseSource::kVisual, 4.1, TrackingState::kTracking, kHere, true, 30);
  halves.say(PoseSource::kLaser, 4.25, TrackingState::kUncertain, kElsewhere, false);
  EXPECT_NE(halves.verdict(), Verdict::kLost);
  halves.say(PoseSource::kLaser, 4.5, TrackingState::kTracking, kElsewhere, false);

  EXPECT_NE(halves.verdict(), Verdict::kLost);
}

TEST(CarryWatch, BothLostIsACarryAfterAMoment) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 2.1, TrackingState::kLost);
  EXPECT_FALSE(halves.carried());

  halves.say(PoseSource::kLaser, 2.5, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 2.65, TrackingState::kLost);

  EXPECT_TRUE(halves.carried());
}

/// A look-alike room: the pictures know at once where they are, the laser searches.
TEST(CarryWatch, OneLostAndTheOtherElsewhereIsACarryToo) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 2.1, TrackingState::kUncertain);
  halves.say(PoseSource::kVisual, 2.2, TrackingState::kTracking, kElsewhere, false);
  EXPECT_FALSE(halves.carried());

  halves.say(PoseSource::kLaser, 2.75, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 2.8, TrackingState::kTracking, kElsewhere, false);

  EXPECT_TRUE(halves.carried());
}

TEST(CarryWatch, OneLostWhileTheOtherSeesNothingIsACarryAfterASecond) {
  Halves halves;
  track(halves, 2.0);
  for (double time = 2.0; time < 2.9; time += 0.2) {
    halves.say(PoseSource::kLaser, time, TrackingState::kLost);
    halves.say(PoseSource::kVisual, time + 0.1, TrackingState::kUncertain, kHere, true, 0);
    EXPECT_FALSE(halves.carried());
  }
  halves.say(PoseSource::kLaser, 3.1, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 3.2, TrackingState::kUncertain, kHere, true, 0);

  EXPECT_TRUE(halves.carried());
}

/// As a closed loop looks.
TEST(CarryWatch, OneThatIsElsewhereWithoutAnyoneLostIsNone) {
  Halves halves;
  track(halves, 2.0);

  for (int n = 0; n < 20; ++n) {
    halves.say(PoseSource::kLaser, 2.0 + 0.25 * n, TrackingState::kTracking, kElsewhere, false);
    halves.say(PoseSource::kVisual, 2.1 + 0.25 * n, TrackingState::kTracking);
    EXPECT_FALSE(halves.carried());
  }
  EXPECT_EQ(halves.verdict(), Verdict::kTracking);
}

TEST(CarryWatch, OneThatWasLostAndFindsItselfElsewhereMakesThePoseLost) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);
  halves.say(PoseSource::kLaser, 2.2, TrackingState::kTracking, kElsewhere, false);

  EXPECT_EQ(halves.verdict(), Verdict::kLost);
  EXPECT_FALSE(halves.carried()) << "the visual half is healthy";
  halves.say(PoseSource::kVisual, 2.3, TrackingState::kUncertain);
  EXPECT_TRUE(halves.carried());
}

TEST(CarryWatch, AMapWithoutScaleThatBendsIsNotElsewhere) {
  SupervisionOptions options;
  options.visual_scale_drifts = true;
  Halves halves(options);
  track(halves, 2.0);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);

  halves.say(PoseSource::kVisual, 2.2, TrackingState::kTracking, kElsewhere, false);
  halves.say(PoseSource::kLaser, 2.75, TrackingState::kLost);
  halves.say(PoseSource::kVisual, 2.8, TrackingState::kTracking, kElsewhere, false);

  EXPECT_FALSE(halves.carried());
}

TEST(CarryWatch, AfterACarryOnlyTheHalfThatNoticedMayStartThePoseAnew) {
  Halves halves;
  track(halves, 2.0);
  halves.say(PoseSource::kVisual, 2.0, TrackingState::kUncertain);
  halves.say(PoseSource::kLaser, 2.0, TrackingState::kLost);
  halves.say(PoseSource::kLaser, 2.2, TrackingState::kTracking, kElsewhere, false);
  ASSERT_TRUE(halves.carried());

  halves.watch.give_up(halves.monitors, halves.now);

  common::PoseEstimate estimate;
  estimate.source = PoseSource::kVisual;
  EXPECT_FALSE(halves.watch.may_start(estimate, halves.monitors, halves.now));
  estimate.source = PoseSource::kLaser;
  EXPECT_TRUE(halves.watch.may_start(estimate, halves.monitors, halves.now));
  estimate.state = TrackingState::kUncertain;
  EXPECT_FALSE(halves.watch.may_start(estimate, halves.monitors, halves.now));
}

TEST(CarryWatch, ASilenceOfBothIsDoubtedUnlessAllInputPaused) {
  Halves halves;
  track(halves, 2.0);
  Halves paused = halves;

  halves.say(PoseSource::kLaser, 4.0, TrackingState::kTracking);
  paused.watch.shift(common::from_seconds(2.0));
  paused.say(PoseSource::kLaser, 4.0, TrackingState::kTracking);

  EXPECT_EQ(halves.verdict(), Verdict::kSuspect);
  EXPECT_EQ(paused.verdict(), Verdict::kTracking);
}

}  // namespace
}  // namespace slamfuse::fusion
