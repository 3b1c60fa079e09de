// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/resampling.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::laser_slam {
namespace {

using ::testing::ElementsAre;

TEST(NormalizedWeights, SurviveHugeAndInfiniteLogarithms) {
  const auto weights = normalized_weights(std::vector<double>{-1e6, -1e6 + std::log(3.0), -HUGE_VAL});
  EXPECT_NEAR(weights[0], 0.25, 1e-9);
  EXPECT_NEAR(weights[1], 0.75, 1e-9);
  EXPECT_EQ(weights[2], 0.0);
  EXPECT_THAT(normalized_weights(std::vector<double>{-HUGE_VAL, -HUGE_VAL}), ElementsAre(0.5, 0.5));
}

TEST(EffectiveNumber, IsTheCountForEqualWeightsAndOneForASingleWinner) {
  EXPECT_DOUBLE_EQ(effective_number(std::vector<double>(8, 0.125)), 8.0);
  EXPECT_DOUBLE_EQ(effective_number(std::vector<double>{0.0, 1.0, 0.0}), 1.0);
  EXPECT_DOUBLE_EQ(effective_number(std::vector<double>{0.5, 0.5, 0.0}), 2.0);
}

TEST(SystematicResampling, KeepsEachParticleOnceWhenWeightsAreEqual) {
  for (const double offset : {0.0, 0.3, 0.999}) {
    EXPECT_THAT(systematic_resampling(std::vector<double>(4, 0.25), offset), ElementsAre(0, 1, 2, 3)) << offset;
  }
}

TEST(SystematicResampling, GivesEachParticleTheFloorOrTheCeilingOfItsShare) {
  const std::vector<double> weights{0.05, 0.0, 0.62, 0.08, 0.25};
  for (double offset = 0.0; offset < 1.0; offset += 0.01) {
    const auto parents = systematic_resampling(weights, offset);
    ASSERT_EQ(parents.size(), weights.size());
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const auto children = std::count(parents.begin(), parents.end(), static_cast<int>(i));
      EXPECT_GE(children, std::floor(weights[i] * 5 - 1e-9));
      EXPECT_LE(children, std::ceil(weights[i] * 5 + 1e-9));
    }
  }
}

TEST(SystematicResampling, NeverChoosesAParticleWithoutWeightThoughRoundingFallsShort) {
  std::vector<double> weights(7, 1.0 / 7.0 - 1e-12);
  weights.push_back(0.0);
  const auto parents = systematic_resampling(weights, 0.9999999999999);
  ASSERT_EQ(parents.size(), 8u);
  EXPECT_EQ(parents.back(), 6);
}

}  // namespace
}  // namespace slamfuse::laser_slam
