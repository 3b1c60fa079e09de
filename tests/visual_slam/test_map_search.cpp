// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/map_search.hpp"

#include <gtest/gtest.h>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

TEST(MapSearch, FindsPlanarPosesAndMayBeSwitchedOff) {
  VisualSlamOptions options;
  const Ekf planar(options.filter, options.motion);
  EXPECT_TRUE(MapSearch(options, 1).is_possible(planar));
  options.motion.model = MotionModelKind::kFreeCamera;
  EXPECT_FALSE(MapSearch(options, 1).is_possible(Ekf(options.filter, options.motion)));
  options.relocalisation.enabled = false;
  EXPECT_FALSE(MapSearch(options, 1).is_possible(planar));
}

TEST(MapSearch, ThePoseIsDoubtedUntilItIsSetOrTheMapForgotten) {
  MapSearch search({}, 1);
  EXPECT_FALSE(search.pose_is_doubted());
  search.doubt_pose();
  EXPECT_TRUE(search.pose_is_doubted());
  search.pose_was_set();
  EXPECT_FALSE(search.pose_is_doubted());
  search.doubt_pose();
  search.clear();
  EXPECT_FALSE(search.pose_is_doubted());
  EXPECT_FALSE(search.was_placed());
}

TEST(MapSearch, AsksForFeaturesOnlyWhenALoopIsDue) {
  VisualSlamOptions options;
  options.loop.interval = 0.5;
  const Ekf filter(options.filter, options.motion);
  const Camera camera = testing::make_camera("cam0", 0.0);
  MapSearch search(options, 1);
  int asked = 0;
  const auto features = [&asked](int) {
    ++asked;
    return std::vector<Eigen::Vector2d>();
  };
  const cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(0));
  for (int i = 0; i < 10; ++i) {
    Glimpse glimpse;
    glimpse.stamp = i * common::kNanosecondsPerSecond / 5;
    glimpse.camera = &camera;
    EXPECT_FALSE(search.find_loop(
        filter, [](common::Nanoseconds) { return std::vector<common::Landmark>(); }, glimpse, picture, features));
  }
  EXPECT_EQ(asked, 4);  // at 0, 0.6, 1.2 and 1.8 s
}

}  // namespace
}  // namespace slamfuse::visual_slam
