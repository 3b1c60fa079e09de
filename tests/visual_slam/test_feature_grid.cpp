// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_grid.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

FrontEndOptions two_by_one() {
  FrontEndOptions options;
  options.grid_columns = 2;
  options.grid_rows = 1;
  options.min_spacing = 5.0;
  return options;
}

TEST(SpreadFeatures, CellsTakeTurnsAndTheStrongestOfEachComeFirst) {
  const std::vector<Eigen::Vector2d> candidates{{10, 10}, {20, 10}, {30, 10}, {80, 10}};
  EXPECT_EQ(spread_features(candidates, {}, 3, {100, 50}, two_by_one()), (std::vector<std::size_t>{0, 3, 1}));
}

TEST(SpreadFeatures, WhatIsTakenFillsItsCellAndKeepsOthersAway) {
  const std::vector<Eigen::Vector2d> candidates{{10, 10}, {20, 10}, {80, 10}};
  const std::vector<Eigen::Vector2d> taken{{11, 11}, {40, 40}};
  EXPECT_EQ(spread_features(candidates, taken, 1, {100, 50}, two_by_one()), (std::vector<std::size_t>{2}));
  EXPECT_EQ(spread_features(candidates, taken, 9, {100, 50}, two_by_one()), (std::vector<std::size_t>{2, 1}));
}

TEST(SpreadFeatures, NothingWantedOrNothingThereGivesNothing) {
  const std::vector<Eigen::Vector2d> candidates{{10, 10}};
  EXPECT_TRUE(spread_features(candidates, {}, 0, {100, 50}, two_by_one()).empty());
  EXPECT_TRUE(spread_features(candidates, {}, -3, {100, 50}, two_by_one()).empty());
  EXPECT_TRUE(spread_features({}, {}, 3, {100, 50}, two_by_one()).empty());
}

}  // namespace
}  // namespace slamfuse::visual_slam
