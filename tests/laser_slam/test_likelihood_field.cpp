// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/likelihood_field.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "laser_slam/beam_model.hpp"
#include "laser_slam/random_stream.hpp"
#include "laser_slam/scan_explanation.hpp"

namespace slamfuse::laser_slam {
namespace {

common::OccupancyGrid grid_of(int width, int height, std::int8_t value) {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = width;
  grid.height = height;
  grid.origin = {-1.0, 2.0};
  grid.cells.assign(static_cast<std::size_t>(width * height), value);
  return grid;
}

std::int8_t& cell(common::OccupancyGrid& grid, int column, int row) {
  return grid.cells[static_cast<std::size_t>(row * grid.width + column)];
}

Eigen::Vector2d centre(const common::OccupancyGrid& grid, int column, int row) {
  return grid.origin + Eigen::Vector2d(column + 0.5, row + 0.5) * grid.resolution;
}

TEST(LikelihoodField, GivesTheExactDistanceToTheNearestOccupiedCell) {
  common::OccupancyGrid grid = grid_of(41, 27, 0);
  RandomStream random(5, 0);
  for (int i = 0; i < 12; ++i) {
    cell(grid, static_cast<int>(random.uniform() * 41), static_cast<int>(random.uniform() * 27)) = 100;
  }
  const double cap = 2.0;
  const LikelihoodField field(grid, cap);
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      double nearest = cap;
      for (int r = 0; r < grid.height; ++r) {
        for (int c = 0; c < grid.width; ++c) {
          if (grid.at(c, r) == 100) nearest = std::min(nearest, 0.1 * std::hypot(c - column, r - row));
        }
      }
      EXPECT_NEAR(field.distance_at(centre(grid, column, row)), nearest, cap / LikelihoodField::kFarthest);
    }
  }
}

TEST(LikelihoodField, IsFarAndUnknownEverywhereWithoutAWallAndOutside) {
  const common::OccupancyGrid grid = grid_of(5, 4, 0);
  const LikelihoodField field(grid, 0.7);
  EXPECT_DOUBLE_EQ(field.distance_at(centre(grid, 2, 2)), 0.7);
  EXPECT_TRUE(LikelihoodField::is_free(field.code_at(centre(grid, 2, 2))));
  for (const Eigen::Vector2d& outside : {Eigen::Vector2d(-1.01, 2.1), Eigen::Vector2d(0.0, 2.41)}) {
    EXPECT_DOUBLE_EQ(field.distance_at(outside), 0.7);
    EXPECT_FALSE(LikelihoodField::is_free(field.code_at(outside)));
  }
}

TEST(LikelihoodField, TellsOnlyAnOccupiedCellOccupiedHoweverCoarseItsSteps) {
  common::OccupancyGrid grid = grid_of(3, 1, 0);
  cell(grid, 0, 0) = 100;
  const LikelihoodField field(grid, 100.0);
  EXPECT_TRUE(LikelihoodField::is_occupied(field.code(0, 0)));
  EXPECT_FALSE(LikelihoodField::is_occupied(field.code(1, 0)));
}

TEST(LikelihoodField, SeesAWallAcrossALineAndNothingElse) {
  common::OccupancyGrid grid = grid_of(60, 60, 0);
  for (int row = 0; row < 60; ++row) cell(grid, 30, row) = 100;
  const LikelihoodField field(grid, 1.0);
  EXPECT_TRUE(field.passes_wall(centre(grid, 5, 10), centre(grid, 55, 50), 0.2));
  EXPECT_FALSE(field.passes_wall(centre(grid, 5, 10), centre(grid, 28, 50), 0.2));
  EXPECT_FALSE(field.passes_wall(centre(grid, 5, 5), centre(grid, 5, 5), 0.2));
  EXPECT_FALSE(field.passes_wall(centre(grid, 5, 20), centre(grid, 31, 20), 0.2)) << "ends at the wall";
  EXPECT_FALSE(field.passes_wall(centre(grid, 30, 5), centre(grid, 31, 55), 0.2)) << "grazes it";
}

/// Looks at every half cell.
bool passes_wall_plainly(const LikelihoodField& field, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                         double beyond) {
  const int steps = static_cast<int>(std::ceil(2.0 * (to - from).norm() / field.resolution()));
  bool met = false;
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector2d point = from + (to - from) * (static_cast<double>(i) / steps);
    if (met && field.distance_at(point) >= beyond) return true;
    met = met || LikelihoodField::is_occupied(field.code_at(point));
  }
  return false;
}

TEST(LikelihoodField, LeavesOutNoWallWhereItLeavesOutSteps) {
  common::OccupancyGrid grid = grid_of(90, 70, 0);
  RandomStream random(11, 0);
  for (int i = 0; i < 60; ++i) {
    const int column = static_cast<int>(random.uniform() * 90), row = static_cast<int>(random.uniform() * 60);
    for (int k = 0; k < 8; ++k) cell(grid, column, row + k) = 100;
  }
  const LikelihoodField field(grid, 1.0);
  const auto anywhere = [&] {
    return Eigen::Vector2d(grid.origin + 0.1 * Eigen::Vector2d(random.uniform() * 90, random.uniform() * 70));
  };
  int through = 0;
  const int tried = 2000;
  for (int i = 0; i < tried; ++i) {
    const Eigen::Vector2d from = anywhere(), to = anywhere();
    const bool expected = passes_wall_plainly(field, from, to, 0.2);
    EXPECT_EQ(field.passes_wall(from, to, 0.2), expected) << from.transpose() << " to " << to.transpose();
    through += expected ? 1 : 0;
  }
  EXPECT_GT(through, tried / 5);
  EXPECT_LT(through, tried * 4 / 5);
}

TEST(BeamModel, BelievesInGlassButNotInAWholeScanThroughWalls) {
  common::OccupancyGrid grid = grid_of(60, 60, 0);
  for (int row = 0; row < 60; ++row) cell(grid, 30, row) = cell(grid, 50, row) = 100;
  const LikelihoodField field(grid, 1.0);
  const BeamModel model(field, BeamModelOptions{});
  const common::Pose2 pose{centre(grid, 10, 30).x(), centre(grid, 10, 30).y(), 0.0};
  const auto traced = [&](double x) { return model.traced_log_likelihood({{x, 0.0}}, {0.0, 0.0}, pose); };
  EXPECT_NEAR(traced(2.0), 0.0, 0.1) << "the first wall";
  EXPECT_EQ(traced(2.0), model.log_likelihood({{2.0, 0.0}}, pose));
  EXPECT_NEAR(traced(4.0), std::log(0.2 / 1.2), 0.1) << "the second wall through the first";
  EXPECT_NEAR(traced(3.0), std::log(0.05 / 1.05), 1e-6) << "nothing behind the first wall";
  EXPECT_NEAR(traced(1.0), std::log(0.2 / 1.2), 0.1) << "a person";
}

TEST(BeamModel, PunishesABeamThatMeetsAPersonLessThanOneThatLeavesTheMap) {
  common::OccupancyGrid grid = grid_of(60, 60, 0);
  for (int row = 0; row < 60; ++row) {
    cell(grid, 30, row) = 100;
    for (int column = 31; column < 60; ++column) cell(grid, column, row) = common::OccupancyGrid::kUnknown;
  }
  const LikelihoodField field(grid, 1.0);
  const BeamModel model(field, BeamModelOptions{});
  const double at_wall = model.log_likelihood(field.code_at(centre(grid, 30, 20)));
  const double person = model.log_likelihood(field.code_at(centre(grid, 10, 20)));
  const double beyond = model.log_likelihood(field.code_at(centre(grid, 50, 20)));
  EXPECT_NEAR(at_wall, 0.0, 1e-6);
  EXPECT_LT(person, -1.0);
  EXPECT_LT(beyond, person - 1.0);
}

TEST(BeamModel, WithSlackBoundsTheLikelihoodOfEveryPoseThatNear) {
  common::OccupancyGrid grid = grid_of(60, 60, 0);
  for (int row = 0; row < 60; ++row) cell(grid, 30, row) = 100;
  const LikelihoodField field(grid, 1.0);
  const BeamModel exact(field, BeamModelOptions{});
  const BeamModel forgiving(field, BeamModelOptions{}, 0.2);
  const std::vector<Eigen::Vector2d> points = {{1.0, 0.2}, {0.7, -0.4}, {2.1, 0.0}};
  const common::Pose2 pose{0.95, 5.05, 0.0};
  for (double shift = -0.15; shift <= 0.15; shift += 0.05) {
    EXPECT_GE(forgiving.log_likelihood(points, pose), exact.log_likelihood(points, {0.95 + shift, 5.05, 0.0}) - 1e-9);
  }
}

TEST(ScanExplanation, TellsTheFourKindsOfBeamsApart) {
  common::OccupancyGrid grid = grid_of(60, 60, 0);
  for (int row = 0; row < 60; ++row) {
    cell(grid, 30, row) = 100;
    for (int column = 31; column < 60; ++column) cell(grid, column, row) = common::OccupancyGrid::kUnknown;
  }
  for (int column = 0; column < 30; ++column) {
    for (int row = 50; row < 60; ++row) cell(grid, column, row) = common::OccupancyGrid::kUnknown;
  }
  const LikelihoodField field(grid, 1.0);
  const common::Pose2 pose{0.05, 4.05, 0.0};  // in the cell (10, 20), 2 m before the wall
  const std::vector<Eigen::Vector2d> points = {{2.0, 0.0}, {1.0, 0.0}, {3.5, 0.0}, {0.0, 3.5}};
  const ScanExplanation explanation = explain_scan(field, {0.0, 0.0}, points, pose, 0.12);
  EXPECT_EQ(explanation.explained, 1);
  EXPECT_EQ(explanation.in_the_way, 1);
  EXPECT_EQ(explanation.contradicted, 1);
  EXPECT_EQ(explanation.unmapped, 1);
  EXPECT_NEAR(explanation.agreement(0.5), 1.0 / 2.5, 1e-6);
  EXPECT_NEAR(explanation.agreement(0.0), 1.0 / 2.0, 1e-6);
}

TEST(ScanExplanation, DoesNotAgreeWhenTheScanIsNearlyAllUnmapped) {
  EXPECT_EQ((ScanExplanation{1, 0, 0, 9}.agreement(0.5)), 0.0);
  EXPECT_EQ(ScanExplanation{}.agreement(0.5), 0.0);
}

}  // namespace
}  // namespace slamfuse::laser_slam
