// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_supply.hpp"

#include <gtest/gtest.h>

#include "visual_slam/drawn_scene.hpp"

namespace slamfuse::visual_slam {
namespace {

class FeatureSupplyTest : public ::testing::Test {
 protected:
  FeatureSupplyTest() : supply_(options_, *FeatureSelection::create(options_.selection), 1) {
    supply_.follow(0, camera_, picture_, {});
  }

  VisualSlamOptions options_;
  Camera camera_ = testing::make_camera("cam0", 0.0);
  cv::Mat picture_ = testing::drawn_picture({640, 480}, 3);
  FeatureSupply supply_;
};

TEST_F(FeatureSupplyTest, AFewMissingFeaturesAreNotMissed) {
  const auto wanted = static_cast<std::size_t>(options_.front_end.features_per_image);
  EXPECT_EQ(supply_.missing(0), static_cast<int>(wanted));
  EXPECT_EQ(supply_.missing(wanted - 2), 0);
  EXPECT_EQ(supply_.missing(wanted + 5), 0);
  EXPECT_EQ(supply_.missing(wanted / 2), static_cast<int>(wanted - wanted / 2));
}

TEST_F(FeatureSupplyTest, NewFeaturesKeepAwayFromThoseFollowed) {
  std::vector<Track> tracks;
  for (const auto& feature : supply_.refill(0, picture_, {})) tracks.push_back({0, feature.pixel});
  ASSERT_EQ(static_cast<int>(tracks.size()), options_.front_end.features_per_image);
  EXPECT_TRUE(supply_.refill(0, picture_, tracks).empty());

  tracks.resize(tracks.size() / 2);
  const auto more = supply_.refill(0, picture_, tracks);
  EXPECT_FALSE(more.empty());
  for (const auto& feature : more) {
    for (const Track& track : tracks) {
      EXPECT_GT((feature.pixel - track.pixel).norm(), 0.9 * options_.front_end.min_spacing);
    }
  }
}

TEST_F(FeatureSupplyTest, FollowsWhatThePictureBeforeShowed) {
  std::vector<ExpectedFeature> expected;
  for (const auto& feature : supply_.refill(0, picture_, {})) {
    expected.push_back({static_cast<std::int64_t>(expected.size()), feature.pixel, feature.pixel});
  }
  const cv::Mat shift = (cv::Mat_<double>(3, 3) << 1, 0, 3, 0, 1, 2, 0, 0, 1);
  const std::vector<Track> seen = supply_.follow(0, camera_, testing::moved_picture(picture_, shift), expected);

  EXPECT_GT(seen.size(), expected.size() / 2);
  int right = 0;
  for (const Track& track : seen) {
    const Eigen::Vector2d moved = track.pixel - expected[static_cast<std::size_t>(track.landmark)].last;
    right += (moved - Eigen::Vector2d(3.0, 2.0)).norm() < 0.3 ? 1 : 0;
  }
  EXPECT_GT(right, static_cast<int>(9 * seen.size() / 10));
}

}  // namespace
}  // namespace slamfuse::visual_slam
