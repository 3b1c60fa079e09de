// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/tracking_monitor.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

using common::TrackingState;

constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;
constexpr ImageEvidence kGood{50, 45, true};
constexpr ImageEvidence kDark{50, 0, false};
constexpr ImageEvidence kElsewhere{50, 0, true};

TEST(TrackingMonitor, GoodImagesAreTracked) {
  TrackingMonitor monitor({});

  EXPECT_EQ(monitor.update(0, {0, 0, true}), TrackingState::kTracking);
  EXPECT_EQ(monitor.update(kSecond, kGood), TrackingState::kTracking);
}

TEST(TrackingMonitor, DarknessIsUncertainThenLostAndTheMapMayGrowAgainAfterwards) {
  TrackingMonitor monitor({});
  monitor.update(0, kGood);

  EXPECT_EQ(monitor.update(kSecond / 5, kDark), TrackingState::kTracking);
  EXPECT_EQ(monitor.update(kSecond, kDark), TrackingState::kUncertain);
  EXPECT_EQ(monitor.update(4 * kSecond, kDark), TrackingState::kLost);
  EXPECT_TRUE(monitor.map_may_grow());
  EXPECT_EQ(monitor.update(5 * kSecond, kGood), TrackingState::kTracking);
}

TEST(TrackingMonitor, SeeingSomethingElseIsUncertainAtOnceSoonLostAndStopsTheMap) {
  TrackingMonitor monitor({});
  monitor.update(0, kGood);

  EXPECT_EQ(monitor.update(kSecond / 5, kElsewhere), TrackingState::kUncertain);
  EXPECT_FALSE(monitor.map_may_grow());
  EXPECT_EQ(monitor.update(kSecond, {0, 3, true}), TrackingState::kLost);
  EXPECT_FALSE(monitor.map_may_grow());
  EXPECT_EQ(monitor.update(2 * kSecond, kGood), TrackingState::kTracking);
  EXPECT_TRUE(monitor.map_may_grow());
}

TEST(TrackingMonitor, AsksForTextureOnlyWhereItDecides) {
  TrackingMonitor monitor({});
  monitor.update(0, kGood);

  EXPECT_FALSE(monitor.asks_for_texture(kGood));
  EXPECT_FALSE(monitor.asks_for_texture({15, 0, false})) << "nothing much was expected";
  EXPECT_TRUE(monitor.asks_for_texture(kDark));
  monitor.update(kSecond / 5, kElsewhere);
  EXPECT_FALSE(monitor.asks_for_texture(kDark)) << "contradicted already";
}

TEST(TrackingMonitor, APoseFromOutsideIsUncertainUntilTheMapIsSeen) {
  TrackingMonitor monitor({});
  monitor.update(0, kGood);

  monitor.pose_was_set();

  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
  EXPECT_EQ(monitor.update(kSecond, {0, 0, true}), TrackingState::kUncertain);
  EXPECT_EQ(monitor.update(kSecond + kSecond / 5, kGood), TrackingState::kTracking);
}

}  // namespace
}  // namespace slamfuse::visual_slam
