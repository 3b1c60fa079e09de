// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/pose_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "drawn_map.hpp"
#include "laser_slam/place_scores.hpp"
#include "laser_slam/random_stream.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;

/// Ends of beams all round from a pose in the room.
std::vector<Eigen::Vector2d> beams_from(const Pose2& pose) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 90; ++i) {
    const double bearing = i * 2.0 * M_PI / 90.0;
    const double range = testing::cast(testing::room(), pose.translation(), pose.theta + bearing);
    points.emplace_back(range * std::cos(bearing), range * std::sin(bearing));
  }
  return points;
}

/// A grid of random cells: a tenth occupied, a fifth unknown.
common::OccupancyGrid random_grid(int width, int height) {
  common::OccupancyGrid grid;
  grid.width = width;
  grid.height = height;
  grid.origin = {-3.0, 1.0};
  RandomStream random(3, 0);
  for (int i = 0; i < width * height; ++i) {
    const double drawn = random.uniform();
    grid.cells.push_back(drawn < 0.1   ? std::int8_t{100}
                         : drawn < 0.3 ? common::OccupancyGrid::kUnknown
                                       : std::int8_t{0});
  }
  return grid;
}

TEST(PlaceScores, AreTheBeamModelsAtEveryFreePlace) {
  const common::OccupancyGrid grid = random_grid(97, 61);
  const LikelihoodField field(grid, 1.0);
  BeamModelOptions nothing_outside, something_outside;
  something_outside.random_likelihood = 0.3;
  something_outside.short_likelihood = 0.1;
  RandomStream random(4, 0);
  for (const BeamModelOptions& options : {nothing_outside, something_outside}) {
    const BeamModel model(field, options);
    for (const int stride : {1, 3, 4}) {
      for (const int beams : {1, 40, 400}) {
        const PlaceScores scores(field, model, stride, beams);
        // Some end outside the map, some farther away than it is wide.
        std::vector<std::array<int, 2>> offsets;
        for (int i = 0; i < beams; ++i) {
          offsets.push_back(
              {static_cast<int>(random.uniform() * 240) - 120, static_cast<int>(random.uniform() * 90) - 45});
        }
        std::vector<std::uint16_t> scored;
        scores.score(offsets, scored);
        ASSERT_EQ(scored.size(), scores.places());
        std::size_t place = 0;
        for (int row = stride / 2; row < grid.height; row += stride) {
          for (int column = stride / 2; column < grid.width; column += stride) {
            if (!LikelihoodField::is_free(field.code(column, row))) continue;
            double plain = 0.0;
            for (const auto& [dx, dy] : offsets) {
              plain += static_cast<double>(model.log_likelihood(field.code(column + dx, row + dy)));
            }
            ASSERT_LT(place, scores.places());
            EXPECT_NEAR(scores.log_likelihood(scored[place], offsets.size()), plain,
                        (scores.rounding() + 1e-6) * static_cast<double>(offsets.size()));
            EXPECT_EQ(field.code_at(scores.position(place)), field.code(column, row));
            ++place;
          }
        }
        EXPECT_EQ(place, scores.places());
      }
    }
  }
}

TEST(PoseSearch, FindsThePoseAmongTheBestOfAWholeMap) {
  const LocalizationMap map = testing::room_map();
  const LikelihoodField field(map.grid, 1.0);
  const PoseSearch search(field, BeamModelOptions{}, PoseSearchOptions{});
  const Pose2 truth{3.3, 1.4, -2.2};
  const auto points = beams_from(truth);
  const auto found = search.search(points, {0.0, 0.0});
  ASSERT_FALSE(found.empty());
  EXPECT_LT(testing::distance(found.front().pose, truth), 0.08);
  EXPECT_LT(std::abs(common::angle_difference(found.front().pose.theta, truth.theta)), 0.04);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end(), [](const PoseCandidate& a, const PoseCandidate& b) {
    return a.log_likelihood > b.log_likelihood;
  }));
  EXPECT_TRUE(search.search({}, {0.0, 0.0}).empty());
}

TEST(PoseSearch, FindsWhatTryingEveryPoseFinds) {
  const LocalizationMap map = testing::room_map();
  const LikelihoodField field(map.grid, 1.0);
  const BeamModel model(field, BeamModelOptions{});
  const PoseSearch search(field, BeamModelOptions{}, PoseSearchOptions{});
  RandomStream random(8, 0);
  for (int i = 0; i < 3; ++i) {
    const Pose2 truth{-2.5 + 3.5 * random.uniform(), 2.0 * random.uniform(), 6.0 * random.uniform() - 3.0};
    const auto points = beams_from(truth);
    Pose2 best;
    double most = -HUGE_VAL;
    for (double x = -3.0; x < 5.0; x += 0.1) {
      for (double y = -2.0; y < 4.0; y += 0.1) {
        if (!LikelihoodField::is_free(field.code_at({x, y}))) continue;
        for (double theta = -M_PI; theta < M_PI; theta += 0.1) {
          const double likelihood = model.traced_log_likelihood(points, {0.0, 0.0}, {x, y, theta});
          if (likelihood <= most) continue;
          most = likelihood;
          best = {x, y, theta};
        }
      }
    }
    const auto found = search.search(points, {0.0, 0.0});
    ASSERT_FALSE(found.empty());
    EXPECT_GE(found.front().log_likelihood, most);
    EXPECT_LT(testing::distance(found.front().pose, best), 0.2) << truth.x << ' ' << truth.y << ' ' << truth.theta;
  }
}

}  // namespace
}  // namespace slamfuse::laser_slam
