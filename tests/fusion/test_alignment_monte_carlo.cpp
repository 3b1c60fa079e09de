// SPDX-License-Identifier: BSD-3-Clause
// Whether the uncertainty an alignment states is that of its errors, over noise, outliers, overlap and shape of path.
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "common/angle.hpp"
#include "fusion/alignment.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace slamfuse::fusion {
namespace {

/// 95 % quantile of chi-square with four degrees of freedom.
constexpr double kChiSquare95Of4 = 9.488;

common::Trajectory2 round_trip(std::size_t count) {
  common::Trajectory2 path;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.03 * static_cast<double>(i);
    path.push_back({kTestStart + static_cast<common::Nanoseconds>(i) * kTestStep,
                    {4.0 * std::cos(t), 1.5 * std::sin(t), std::atan2(1.5 * std::cos(t), -4.0 * std::sin(t))}});
  }
  return path;
}

struct Case {
  std::string name;
  common::Trajectory2 laser;
  double noise = 0.02;    ///< [m]
  double outliers = 0.0;  ///< share
  double overlap = 1.0;   ///< part of the drive that the visual half saw
};

std::vector<Case> cases() {
  return {{"little noise", flat_path(300), 0.005, 0.0, 1.0},     {"much noise", flat_path(300), 0.05, 0.0, 1.0},
          {"20 % outliers", flat_path(300), 0.02, 0.2, 1.0},     {"40 % outliers", flat_path(400), 0.02, 0.4, 1.0},
          {"half of the drive", flat_path(400), 0.02, 0.1, 0.5}, {"another path", round_trip(400), 0.02, 0.1, 1.0}};
}

TEST(AlignmentMonteCarlo, TheTrueMapIsInsideTheStated95PercentEllipsoidIn93To97PercentOfTheRuns) {
  constexpr int kRuns = 160;
  AlignmentOptions options;
  options.method = AlignmentMethod::kSimilarity;
  options.offsets.estimate = false;
  int inside = 0;
  int all = 0;
  for (const Case& drive : cases()) {
    int inside_here = 0;
    for (int run = 0; run < kRuns; ++run) {
      const PlanarAffine truth = stretched_map(2.0 * run, 2.0, 2.0, 1.0, -1.0);
      auto visual = visual_path(drive.laser, truth, drive.noise / 2.0, drive.outliers, 1000 + run);
      visual.resize(static_cast<std::size_t>(drive.overlap * static_cast<double>(visual.size())));

      const Alignment alignment = align_trajectories(drive.laser, visual, options);

      ASSERT_TRUE(alignment.accepted) << drive.name << ": " << alignment.reason;
      const Eigen::Vector4d error(
          alignment.map.linear(0, 0) - truth.linear(0, 0), alignment.map.linear(1, 0) - truth.linear(1, 0),
          alignment.map.translation.x() - truth.translation.x(), alignment.map.translation.y() - truth.translation.y());
      const std::vector<int> places{0, 2, 4, 5};
      const Eigen::Matrix4d covariance = alignment.covariance(places, places);
      if (error.dot(covariance.ldlt().solve(error)) < kChiSquare95Of4) ++inside_here;
    }
    RecordProperty(drive.name, inside_here);
    EXPECT_GE(inside_here, static_cast<int>(0.88 * kRuns)) << drive.name;
    inside += inside_here;
    all += kRuns;
  }

  EXPECT_GE(inside, static_cast<int>(0.93 * all)) << inside << " of " << all;
  EXPECT_LE(inside, static_cast<int>(0.97 * all)) << inside << " of " << all;
}

}  // namespace
}  // namespace slamfuse::fusion
