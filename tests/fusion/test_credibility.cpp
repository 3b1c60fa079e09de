// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/credibility.hpp"

#include <optional>

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

using common::TrackingState;

common::PoseEstimate seeing(std::optional<int> inliers) {
  common::PoseEstimate estimate;
  estimate.source = common::PoseSource::kVisual;
  estimate.health.inliers = inliers;
  return estimate;
}

TEST(Credibility, EndsWithTheSecondPictureInARowThatShowsNothing) {
  Credibility credibility;
  EXPECT_EQ(credibility.of(seeing(12)), TrackingState::kTracking);
  EXPECT_EQ(credibility.of(seeing(0)), TrackingState::kTracking);
  EXPECT_EQ(credibility.of(seeing(0)), TrackingState::kUncertain);
  EXPECT_EQ(credibility.of(seeing(5)), TrackingState::kTracking);
}

TEST(Credibility, OneCameraOfTwoMayLookAtAWall) {
  Credibility credibility;
  for (int n = 0; n < 10; ++n) {
    EXPECT_EQ(credibility.of(seeing(0)), TrackingState::kTracking);
    EXPECT_EQ(credibility.of(seeing(8)), TrackingState::kTracking);
  }
}

TEST(Credibility, IsNotAskedOfAHalfThatDoesNotCountFeaturesOrSaysItIsLost) {
  Credibility credibility;
  auto lost = seeing(0);
  lost.state = TrackingState::kLost;
  for (int n = 0; n < 10; ++n) {
    EXPECT_EQ(credibility.of(seeing(std::nullopt)), TrackingState::kTracking);
    EXPECT_EQ(credibility.of(lost), TrackingState::kLost);
  }
}

}  // namespace
}  // namespace slamfuse::fusion
