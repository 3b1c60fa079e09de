// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/final_path.hpp"

#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;

ReceivedEstimate received(common::Nanoseconds stamp, common::TrackingState state, std::size_t published) {
  return {stamp, common::PoseSource::kLaser, state, {common::to_seconds(stamp), 0.0, 0.0}, published};
}

std::vector<PublishedPose> published_each_second(int count) {
  std::vector<PublishedPose> published;
  for (int i = 0; i < count; ++i)
    published.push_back({i * kSecond, {static_cast<double>(i), 0.0, 0.0}, static_cast<std::size_t>(i)});
  return published;
}

TEST(AnchorsOf, SkipsLostEstimatesAndFollowsStampsThatStepBack) {
  const std::vector<ReceivedEstimate> estimates = {received(10 * kSecond, common::TrackingState::kTracking, 0),
                                                   received(12 * kSecond, common::TrackingState::kLost, 1),
                                                   received(9 * kSecond, common::TrackingState::kTracking, 2)};
  const common::Trajectory2 path = {{10 * kSecond, {1, 0, 0}}, {12 * kSecond, {2, 0, 0}}, {9 * kSecond, {3, 0, 0}}};

  const auto anchors = anchors_of(path, common::PoseSource::kLaser, estimates);

  ASSERT_EQ(anchors.size(), 2u);
  EXPECT_EQ(anchors[0].T_map_base.x, 1.0);
  EXPECT_EQ(anchors[1].T_map_base.x, 3.0);
  EXPECT_EQ(anchors[1].published, 2u);
  EXPECT_TRUE(anchors_of(path, common::PoseSource::kVisual, estimates).empty());
}

TEST(SmoothPath, GoesThroughTheAnchorsAndBlendsTheirCorrectionsBetweenThem) {
  const std::vector<PathAnchor> anchors = {{0, {5.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0},
                                           {4 * kSecond, {9.4, 0.0, 0.0}, {4.0, 0.0, 0.0}, 4}};

  const auto path = smooth_path(published_each_second(6), anchors);

  ASSERT_EQ(path.size(), 6u);
  EXPECT_NEAR(path[0].pose.x, 5.0, 1e-12);
  EXPECT_NEAR(path[2].pose.x, 7.2, 1e-12);  // half of the correction of 0.4
  EXPECT_NEAR(path[4].pose.x, 9.4, 1e-12);
  EXPECT_NEAR(path[5].pose.x, 10.4, 1e-12);  // by odometry from the last
}

TEST(SmoothPath, DoesNotSmearACarry) {
  const std::vector<PathAnchor> anchors = {{0, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0},
                                           {4 * kSecond, {100.0, 0.0, 0.0}, {4.0, 0.0, 0.0}, 4}};

  const auto path = smooth_path(published_each_second(5), anchors);

  EXPECT_NEAR(path[1].pose.x, 1.0, 1e-12);
  EXPECT_NEAR(path[3].pose.x, 99.0, 1e-12);
}

TEST(SmoothPath, IsEmptyWithoutAnchors) { EXPECT_TRUE(smooth_path(published_each_second(3), {}).empty()); }

TEST(FillGaps, UsesTheSubstituteOnlyWhereTheMainIsSilent) {
  const std::vector<PathAnchor> laser = {{0, {}, {}, 0}, {10 * kSecond, {}, {}, 10}};
  const std::vector<PathAnchor> visual = {{kSecond / 2, {}, {}, 1}, {5 * kSecond, {}, {}, 5}, {9 * kSecond, {}, {}, 9}};

  const auto filled = fill_gaps(laser, visual, kSecond);

  ASSERT_EQ(filled.size(), 3u);
  EXPECT_EQ(filled[1].stamp, 5 * kSecond);
}

}  // namespace
}  // namespace slamfuse::fusion
