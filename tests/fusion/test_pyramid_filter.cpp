// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/pyramid_filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

using testing::ElementsAre;

TEST(PyramidFilter, RoundsToMultiplesOfTheRatioInTheOriginalScale) {
  const ImagePairs filtered = filter_by_pyramid({{{5.9, 6.1}}, {{-3.0, 0.4}}}, 4.0);

  EXPECT_THAT(filtered.laser, ElementsAre(Eigen::Vector2d(4, 8)));
  EXPECT_THAT(filtered.visual, ElementsAre(Eigen::Vector2d(-4, 0)));
}

TEST(PyramidFilter, MergesNeighboursThatBecomeEqualInBothImagesOnly) {
  const ImagePairs filtered =
      filter_by_pyramid({{{0, 0}, {0.4, 0}, {0.4, 0.1}, {9, 0}}, {{0, 0}, {0.2, 0}, {5, 0}, {5, 0}}}, 4.0);

  EXPECT_THAT(filtered.laser, ElementsAre(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 0), Eigen::Vector2d(8, 0)));
  EXPECT_THAT(filtered.visual, ElementsAre(Eigen::Vector2d(0, 0), Eigen::Vector2d(4, 0), Eigen::Vector2d(4, 0)));
}

TEST(PyramidFilter, MovesNoPointByMoreThanHalfTheRatio) {
  ImagePairs pairs;
  for (int i = 0; i < 100; ++i) {
    pairs.laser.emplace_back(0.37 * i, -1.13 * i);
    pairs.visual.emplace_back(7.0 * i, 0.0);  // keeps neighbours apart
  }

  const ImagePairs filtered = filter_by_pyramid(pairs, 3.0);

  ASSERT_EQ(filtered.laser.size(), pairs.laser.size());
  for (std::size_t i = 0; i < pairs.laser.size(); ++i) {
    EXPECT_LE((filtered.laser[i] - pairs.laser[i]).cwiseAbs().maxCoeff(), 1.5 + 1e-12);
  }
}

}  // namespace
}  // namespace slamfuse::fusion
