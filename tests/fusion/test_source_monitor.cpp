// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/source_monitor.hpp"

#include <gtest/gtest.h>

#include "common/time.hpp"

namespace slamfuse::fusion {
namespace {

using common::from_seconds;
using common::TrackingState;

/// A visual half that says the same of itself five times a second for a while.
SourceMonitor heard(TrackingState state, double seconds) {
  SourceMonitor monitor(common::PoseSource::kVisual, {});
  common::PoseEstimate estimate;
  estimate.source = common::PoseSource::kVisual;
  estimate.state = state;
  for (double at = 0.0; at <= seconds; at += 0.2) {
    estimate.stamp = from_seconds(at);
    monitor.estimated(estimate);
  }
  return monitor;
}

TEST(SourceMonitor, BelievesAHalfThatTracks) {
  EXPECT_EQ(heard(TrackingState::kTracking, 3.0).status(from_seconds(3.0)).state, Verdict::kTracking);
}

TEST(SourceMonitor, AMomentOfUncertaintyIsNoSuspicion) {
  const StatusEntry entry = heard(TrackingState::kUncertain, 0.6).status(from_seconds(0.6));
  EXPECT_EQ(entry.state, Verdict::kTracking);
  EXPECT_LT(entry.score, 1.0);
}

// A camera whose picture is frozen calls itself uncertain for three seconds before it calls itself lost.
TEST(SourceMonitor, LongUncertaintyIsSuspect) {
  EXPECT_EQ(heard(TrackingState::kUncertain, 1.4).status(from_seconds(1.4)).state, Verdict::kSuspect);
}

TEST(SourceMonitor, AHalfThatSaysItIsLostIsLost) {
  const SourceMonitor monitor = heard(TrackingState::kLost, 1.0);
  EXPECT_EQ(monitor.status(from_seconds(1.0)).state, Verdict::kLost);
  EXPECT_NEAR(monitor.lost_for(from_seconds(1.5)).value(), 1.5, 1e-9);
}

TEST(SourceMonitor, SilenceIsSuspectThenLost) {
  const SourceMonitor monitor = heard(TrackingState::kTracking, 0.0);
  EXPECT_EQ(monitor.status(from_seconds(1.2)).state, Verdict::kSuspect);
  EXPECT_EQ(monitor.status(from_seconds(2.1)).state, Verdict::kLost);
  EXPECT_FALSE(monitor.lost_for(from_seconds(1.2)).has_value());
}

TEST(SourceMonitor, AHalfThatIsHeldBackIsSuspectAndNoWitness) {
  SourceMonitor monitor = heard(TrackingState::kTracking, 1.0);
  EXPECT_TRUE(monitor.healthy(from_seconds(1.0)));
  monitor.measured({MeasurementOutcome::kHeldBack, 1.0, 0.0}, false);
  EXPECT_EQ(monitor.status(from_seconds(1.0)).state, Verdict::kSuspect);
  EXPECT_FALSE(monitor.healthy(from_seconds(1.0)));
  monitor.measured({MeasurementOutcome::kFused, 1.0, 0.0}, false);
  EXPECT_TRUE(monitor.healthy(from_seconds(1.0)));
}

}  // namespace
}  // namespace slamfuse::fusion
