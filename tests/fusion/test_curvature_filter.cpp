// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/curvature_filter.hpp"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::fusion {
namespace {

using testing::ElementsAre;

constexpr double kThreshold = std::numbers::pi / 6.0;
const Points kStraight = {{0, 0}, {10, 0}, {20, 0}, {30, 0}, {40, 0}};

TEST(CurvatureFilter, KeepsAStraightPath) {
  EXPECT_THAT(filter_by_curvature(kStraight, kStraight, kThreshold, 0.0), ElementsAre(0, 1, 2, 3, 4));
}

/// Misprint 1: as printed, inequality (3) keeps p(k+1) when the angle is small and drops it on a straight path.
TEST(CurvatureFilterMisprint1, DropsThePointAfterASharpTurnAndNotTheStraightOnes) {
  const Points spike = {{0, 0}, {10, 0}, {1, 1}, {30, 0}, {40, 0}};

  const auto kept = filter_by_curvature(spike, kStraight, kThreshold, 0.0);

  EXPECT_THAT(kept, ElementsAre(0, 1, 4));  // (1, 1) turns back at (10, 0), (30, 0) turns back at (1, 1)
}

/// Misprint 1: algorithm 2 lacks the square of D3. With D1 = D2 = 1 and an angle of 40 degrees D3 is 0.684; the printed
/// test, 1 > sqrt(0.684 + 1 - 2 * 0.684 * cos 30), holds just as the right one, but at 25 degrees and D2 = 0.5 they
/// part: the printed one takes 0.5 > sqrt(...) = 0.78 for a turn to drop that the right one keeps at 60 degrees.
TEST(CurvatureFilterMisprint1, MeasuresTheAngleAtTheMiddlePoint) {
  const double angle = std::numbers::pi / 3.0;  // interior angle at (10, 0), twice the threshold
  const Points turn = {{0, 0}, {10, 0}, {10.0 - 5.0 * std::cos(angle), 5.0 * std::sin(angle)}};
  const double d2 = 0.5;
  const double d3 = (turn[2] - turn[0]).norm() / 10.0;
  const bool printed_keeps = d2 > std::sqrt(d3 + 1.0 - 2.0 * d3 * std::cos(kThreshold));

  const auto kept = filter_by_curvature(turn, turn, kThreshold, 0.0);

  EXPECT_FALSE(printed_keeps);
  EXPECT_THAT(kept, ElementsAre(0, 1, 2));
}

TEST(CurvatureFilter, OneTrajectoryTurningBackIsEnough) {
  const Points back = {{0, 0}, {10, 0}, {20, 0}, {11, 1}, {2, 2}};

  EXPECT_THAT(filter_by_curvature(kStraight, back, kThreshold, 0.0), ElementsAre(0, 1, 2, 4));
}

TEST(CurvatureFilter, StepsTooShortToHaveADirectionAreKept) {
  const Points jitter = {{0, 0}, {0.5, 0}, {0, 0}, {0.5, 0}, {0, 0}};

  EXPECT_THAT(filter_by_curvature(jitter, jitter, kThreshold, 1.0), ElementsAre(0, 1, 2, 3, 4));
  const Points standing(4, Eigen::Vector2d(3, 3));
  EXPECT_THAT(filter_by_curvature(standing, standing, kThreshold, 0.0), ElementsAre(0, 1, 2, 3));
}

TEST(CurvatureFilter, TwoPointsAndNoneHaveNoCurvature) {
  EXPECT_THAT(filter_by_curvature({{0, 0}, {1, 0}}, {{0, 0}, {1, 0}}, kThreshold, 0.0), ElementsAre(0, 1));
  EXPECT_TRUE(filter_by_curvature({}, {}, kThreshold, 0.0).empty());
}

}  // namespace
}  // namespace slamfuse::fusion
