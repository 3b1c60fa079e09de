// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/observation_log.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

const std::vector<Track> kTracks{{7, {10.0, 20.0}}, {9, {30.5, 40.25}}};

MapOptions options(int max_keyframes = 100) {
  MapOptions result;
  result.keyframe_distance = 0.5;
  result.keyframe_turn = 30.0;
  result.max_keyframes = max_keyframes;
  return result;
}

TEST(ObservationLog, KeepsAPictureWhenItsCameraHasMovedOrTurned) {
  ObservationLog log(options());

  log.offer(0, 1, {0.0, 0.0, 0.0}, kTracks);
  log.offer(0, 2, {0.4, 0.0, 0.0}, kTracks);
  log.offer(0, 3, {0.6, 0.0, 0.0}, kTracks);
  log.offer(0, 4, {0.6, 0.0, 0.6}, kTracks);

  const auto pictures = log.pictures(0);
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[0].stamp, 1);
  EXPECT_EQ(pictures[1].stamp, 3);
  EXPECT_EQ(pictures[2].stamp, 4);
  ASSERT_EQ(pictures[1].observations.size(), 2U);
  EXPECT_EQ(pictures[1].observations[1].landmark, 9);
  EXPECT_EQ(pictures[1].observations[1].pixel, Eigen::Vector2d(30.5, 40.25));
}

TEST(ObservationLog, KeepsCamerasApart) {
  ObservationLog log(options());

  log.offer(0, 1, {}, kTracks);
  log.offer(2, 1, {}, kTracks);

  EXPECT_EQ(log.pictures(0).size(), 1U);
  EXPECT_TRUE(log.pictures(1).empty());
  EXPECT_EQ(log.pictures(2).size(), 1U);
}

TEST(ObservationLog, PassesOverPicturesWithoutLandmarks) {
  ObservationLog log(options());

  log.offer(0, 1, {}, {});
  log.offer(0, 2, {}, kTracks);

  ASSERT_EQ(log.pictures(0).size(), 1U);
  EXPECT_EQ(log.pictures(0)[0].stamp, 2);
}

TEST(ObservationLog, StaysBoundedAndKeepsTheWholeRun) {
  ObservationLog log(options(10));

  for (int i = 0; i < 200; ++i) log.offer(0, i, {static_cast<double>(i), 0.0, 0.0}, kTracks);

  const auto pictures = log.pictures(0);
  ASSERT_EQ(pictures.size(), 10U);
  EXPECT_EQ(pictures.front().stamp, 0);
  EXPECT_EQ(pictures.back().stamp, 199);
  for (std::size_t i = 1; i < pictures.size(); ++i) EXPECT_LT(pictures[i].stamp - pictures[i - 1].stamp, 80);
}

TEST(ObservationLog, ForgetsEverythingWithTheMap) {
  ObservationLog log(options());
  log.offer(0, 1, {}, kTracks);

  log.clear();
  log.offer(0, 2, {}, kTracks);

  ASSERT_EQ(log.pictures(0).size(), 1U);
  EXPECT_EQ(log.pictures(0)[0].stamp, 2);
}

}  // namespace
}  // namespace slamfuse::visual_slam
