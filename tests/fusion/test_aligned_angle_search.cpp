// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/aligned_angle_search.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

constexpr double kSize = 1000.0;
constexpr double kSeparation = 0.35;

Points positions(const common::Trajectory2& path) {
  Points points;
  for (const auto& pose : path) points.push_back(pose.pose.translation());
  return points;
}

Points filled(const Points& points) {
  return transformed(points, *trajectory_image_matrix(points, kSize, ImagePlane::kKeep));
}

struct Angles {
  int laser = 0;
  int visual = 0;
  double loss = std::numeric_limits<double>::infinity();
};

/// Algorithm 1 word by word: both loops in full, no bound; over the pairs of angles that `admit` lets pass.
template <class Admit>
Angles exhaustive(const Points& laser, const Points& visual, int laser_end, int step_deg, const Admit& admit) {
  const auto images = [&](const Points& points, int end) {
    std::vector<Points> result;
    for (int degrees = 0; degrees < end; degrees += step_deg) {
      result.push_back(filled(transformed(points, aligned_angle_rotation(common::to_radians(degrees)))));
    }
    return result;
  };
  const std::vector<Points> laser_images = images(laser, laser_end);
  const std::vector<Points> visual_images = images(visual, 360);
  Angles best;
  for (std::size_t l = 0; l < laser_images.size(); ++l) {
    for (std::size_t v = 0; v < visual_images.size(); ++v) {
      double sum = 0.0;
      for (std::size_t i = 0; i < laser.size(); ++i) sum += (laser_images[l][i] - visual_images[v][i]).norm();
      const int laser_degrees = static_cast<int>(l) * step_deg;
      const int visual_degrees = static_cast<int>(v) * step_deg;
      if (sum < best.loss && admit(laser_degrees, visual_degrees)) best = {laser_degrees, visual_degrees, sum};
    }
  }
  best.loss /= static_cast<double>(laser.size());
  return best;
}

struct Drive {
  double degrees;
  double scale_x;
  double scale_y;
  double noise;
  double outliers;
};

Angles exhaustive(const Points& laser, const Points& visual, int laser_end, int step_deg) {
  return exhaustive(laser, visual, laser_end, step_deg, [](int, int) { return true; });
}

/// The rotation nearest to the affine map between the two images turned by these angles.
double implied_rotation(const Points& laser, const Points& visual, int laser_degrees, int visual_degrees) {
  const auto turned_and_filled = [](const Points& points, int degrees) -> Eigen::Matrix2d {
    const Eigen::Matrix4d rotation = aligned_angle_rotation(common::to_radians(degrees));
    const auto fill = trajectory_image_matrix(transformed(points, rotation), kSize, ImagePlane::kKeep);
    return (*fill * rotation).topLeftCorner<2, 2>();
  };
  const Eigen::Matrix2d m =
      turned_and_filled(laser, laser_degrees).inverse() * turned_and_filled(visual, visual_degrees);
  return std::atan2(m(1, 0) - m(0, 1), m(0, 0) + m(1, 1));
}

class AlignedAngleSearch : public testing::TestWithParam<Drive> {};

TEST_P(AlignedAngleSearch, EqualsTheExhaustiveSearchOnAOneDegreeGrid) {
  const Drive& drive = GetParam();
  const auto laser_path = flat_path(150);
  const auto path = visual_path(laser_path, stretched_map(drive.degrees, drive.scale_x, drive.scale_y, 1.0, -2.0),
                                drive.noise, drive.outliers, 7);
  const Points laser = filled(positions(laser_path));
  const Points visual = filled(positions(path));

  const auto fast = search_aligned_angles(laser, visual, kSize, common::to_radians(1.0), kSeparation);
  const Angles plain = exhaustive(laser, visual, 90, 1);

  ASSERT_TRUE(fast.has_value());
  EXPECT_NEAR(common::to_degrees(fast->laser), plain.laser, 1e-9);
  EXPECT_NEAR(common::to_degrees(fast->visual), plain.visual, 1e-9);
  EXPECT_NEAR(fast->loss, plain.loss, 1e-7 * kSize);
  EXPECT_GE(fast->runner_up_loss, fast->loss);
}

INSTANTIATE_TEST_SUITE_P(Drives, AlignedAngleSearch,
                         testing::Values(Drive{37.0, 2.0, 2.0, 0.01, 0.0}, Drive{-110.0, 0.3, 0.4, 0.03, 0.0},
                                         Drive{180.0, 1.0, 1.3, 0.02, 0.2}, Drive{5.0, 4.0, 4.1, 0.5, 0.4},
                                         Drive{37.0, 2.0, 2.1, 0.01, 0.1}));

TEST(AlignedAngleSearchRunnerUp, EqualsTheExhaustiveSearchOnAGridThreeTimesAsCoarse) {
  const auto laser_path = flat_path(150);
  const auto path = visual_path(laser_path, stretched_map(37.0, 2.0, 2.1, 1.0, -2.0), 0.01, 0.1, 7);
  const Points laser = filled(positions(laser_path));
  const Points visual = filled(positions(path));

  const auto fast = search_aligned_angles(laser, visual, kSize, common::to_radians(1.0), kSeparation);
  ASSERT_TRUE(fast.has_value());
  const auto best = implied_rotation(laser, visual, static_cast<int>(std::lround(common::to_degrees(fast->laser))),
                                     static_cast<int>(std::lround(common::to_degrees(fast->visual))));
  const Angles plain = exhaustive(laser, visual, 90, 3, [&](int l, int v) {
    return std::abs(common::angle_difference(implied_rotation(laser, visual, l, v), best)) > kSeparation;
  });

  EXPECT_NEAR(fast->runner_up_loss, plain.loss, 1e-7 * kSize);
}

TEST(AlignedAngleSearchRange, AQuarterTurnOfTheLaserCoversAllFour) {
  const auto laser_path = flat_path(120);
  const auto path = visual_path(laser_path, stretched_map(75.0, 2.0, 2.6, 0.0, 0.0), 0.02, 0.0, 3);
  const Points laser = filled(positions(laser_path));
  const Points visual = filled(positions(path));

  const Angles quarter = exhaustive(laser, visual, 90, 5);
  const Angles full = exhaustive(laser, visual, 360, 5);

  EXPECT_NEAR(quarter.loss, full.loss, 1e-9 * kSize);
}

/// Misprint 3: lines 7 and 8 rotate by the result, alpha, which is 0 at the start: the printed search never turns
/// anything and returns the first pair of angles.
TEST(AlignedAngleSearchMisprint3, RotatesByTheAnglesOfTheLoopNotByTheResult) {
  const auto laser_path = flat_path(120);
  const auto path = visual_path(laser_path, stretched_map(64.0, 1.0, 1.0, 0.0, 0.0), 0.0, 0.0, 3);
  const Points laser = filled(positions(laser_path));
  const Points visual = filled(positions(path));
  double as_printed = 0.0;
  for (std::size_t i = 0; i < laser.size(); ++i) as_printed += (laser[i] - visual[i]).norm();
  as_printed /= static_cast<double>(laser.size());

  const auto angles = search_aligned_angles(laser, visual, kSize, common::to_radians(1.0), kSeparation);

  ASSERT_TRUE(angles.has_value());
  EXPECT_LT(angles->loss, 0.05 * as_printed);
  EXPECT_NE(angles->visual, 0.0);
}

TEST(AlignedAngleSearchInput, RefusesLinesAndUnequalLengths) {
  EXPECT_FALSE(search_aligned_angles({}, {}, kSize, 0.1, kSeparation).has_value());
  EXPECT_FALSE(search_aligned_angles({{0, 0}, {1, 1}}, {{0, 0}}, kSize, 0.1, kSeparation).has_value());
  const Points line = {{0, 0}, {1, 0}, {2, 0}};
  EXPECT_FALSE(search_aligned_angles(line, line, kSize, 0.1, kSeparation).has_value());
}

}  // namespace
}  // namespace slamfuse::fusion
