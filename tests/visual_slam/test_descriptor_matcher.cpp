// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/descriptor_matcher.hpp"

#include <gtest/gtest.h>

#include "visual_slam/drawn_scene.hpp"

namespace slamfuse::visual_slam {
namespace {

Features features_of(FeatureKind kind) {
  return FeatureExtractor(kind, 300).extract(testing::drawn_picture({320, 240}, 3));
}

TEST(DescriptorIndex, CompleteSearchIsThePlainOneByOneSearch) {
  const Features features = features_of(FeatureKind::kOrb);
  const cv::Mat queries = features.descriptors.rowRange(0, 20) ^ 5;
  cv::Mat allowed(20, features.descriptors.rows, CV_8UC1);
  for (int i = 0; i < allowed.rows; ++i) {
    for (int j = 0; j < allowed.cols; ++j) allowed.at<unsigned char>(i, j) = (i + j) % 3 != 0 ? 1 : 0;
  }

  const auto found = DescriptorIndex(FeatureKind::kOrb, DescriptorSearch::kComplete, features.descriptors)
                         .nearest(queries, 3, allowed);

  for (int i = 0; i < queries.rows; ++i) {
    double least = 1e9;
    for (int j = 0; j < features.descriptors.rows; ++j) {
      if (allowed.at<unsigned char>(i, j) == 0) continue;
      least = std::min(least, cv::norm(queries.row(i), features.descriptors.row(j), cv::NORM_HAMMING));
    }
    ASSERT_EQ(found[static_cast<std::size_t>(i)].size(), 3U);
    EXPECT_EQ(static_cast<double>(found[static_cast<std::size_t>(i)].front().distance), least);
  }
}

TEST(DescriptorIndex, FlannFindsMostNearestNeighboursAndLeavesTheRandomNumbersAlone) {
  for (const FeatureKind kind : {FeatureKind::kSift, FeatureKind::kOrb}) {
    const Features features = features_of(kind);
    const cv::Mat queries = features.descriptors.rowRange(0, 100);
    cv::theRNG().state = 77;

    const auto found = DescriptorIndex(kind, DescriptorSearch::kFlann, features.descriptors).nearest(queries, 2, {});

    EXPECT_EQ(cv::theRNG().state, 77U);
    int itself = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      itself += !found[i].empty() && found[i].front().distance == 0.0F ? 1 : 0;
    }
    EXPECT_GT(itself, 95);
  }
}

TEST(DescriptorIndex, NothingToSearchGivesNothing) {
  const Features features = features_of(FeatureKind::kOrb);
  for (const DescriptorSearch search : {DescriptorSearch::kComplete, DescriptorSearch::kFlann}) {
    EXPECT_TRUE(DescriptorIndex(FeatureKind::kOrb, search, features.descriptors).nearest({}, 2, {}).empty());
    const auto none =
        DescriptorIndex(FeatureKind::kOrb, search, {}).nearest(features.descriptors.rowRange(0, 2), 2, {});
    ASSERT_EQ(none.size(), 2U);
    EXPECT_TRUE(none.front().empty());
  }
}

TEST(ClearMatch, MustBeNearAndClearlyBetterThanThoseElsewhere) {
  const std::vector<cv::KeyPoint> keypoints{{10.0F, 10.0F, 7.0F}, {11.0F, 10.0F, 7.0F}, {50.0F, 10.0F, 7.0F}};
  const auto match = [&](const std::vector<Neighbour>& neighbours) {
    return clear_match(FeatureKind::kOrb, 0.8, neighbours, keypoints).has_value();
  };

  EXPECT_TRUE(match({{0, 20.0F}, {2, 40.0F}}));
  EXPECT_FALSE(match({{0, 38.0F}, {2, 40.0F}})) << "the second is nearly as good";
  EXPECT_TRUE(match({{0, 20.0F}, {1, 21.0F}, {2, 40.0F}})) << "the second is the same place";
  EXPECT_FALSE(match({{0, 90.0F}})) << "nothing alike";
  EXPECT_FALSE(match({}));
}

}  // namespace
}  // namespace slamfuse::visual_slam
