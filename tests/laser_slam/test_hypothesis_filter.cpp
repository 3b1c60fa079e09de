// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/hypothesis_filter.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "laser_slam/localization_monitor.hpp"
#include "laser_slam/localization_path.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::TrackingState;

/// An empty square of 10 m with walls around.
common::OccupancyGrid square() {
  common::OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.width = grid.height = 100;
  grid.origin = {-5.0, -5.0};
  grid.cells.assign(10000, 0);
  for (int i = 0; i < 100; ++i) {
    for (const int at : {i, 9900 + i, i * 100, i * 100 + 99}) grid.cells[static_cast<std::size_t>(at)] = 100;
  }
  return grid;
}

/// Ends of beams all round from a pose in the square.
std::vector<Eigen::Vector2d> beams_from(const common::Pose2& pose) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 72; ++i) {
    const double bearing = i * 2.0 * M_PI / 72.0;
    const double c = std::cos(pose.theta + bearing);
    const double s = std::sin(pose.theta + bearing);
    const double x = c > 0.0 ? (4.95 - pose.x) / c : (-4.95 - pose.x) / std::min(c, -1e-9);
    const double y = s > 0.0 ? (4.95 - pose.y) / s : (-4.95 - pose.y) / std::min(s, -1e-9);
    points.emplace_back(std::min(x, y) * Eigen::Vector2d(std::cos(bearing), std::sin(bearing)));
  }
  return points;
}

const Eigen::Vector2d kMount = Eigen::Vector2d::Zero();
const int kMost = HypothesisFilterOptions{}.max_particles;

Eigen::Matrix3d spread(double metres) { return Eigen::Vector3d(metres * metres, metres * metres, 0.01).asDiagonal(); }

TEST(KldParticles, GrowWithTheBinsAndMatchFoxsFormula) {
  EXPECT_EQ(kld_particles(1, 0.05, 2.33), 1);
  // k - 1 = 99: 99 / 0.1 * (1 - 2/891 + sqrt(2/891) * 2.33)^3.
  EXPECT_NEAR(kld_particles(100, 0.05, 2.33), 990.0 * std::pow(1.0 - 2.0 / 891 + std::sqrt(2.0 / 891) * 2.33, 3), 1.0);
  EXPECT_LT(kld_particles(100, 0.1, 2.33), kld_particles(100, 0.05, 2.33));
}

TEST(HypothesisFilter, TakesMoreParticlesForAWiderSpreadButNeverTooMany) {
  const HypothesisFilterOptions options;
  HypothesisFilter narrow(options, 1), wide(options, 1), huge(options, 1);
  narrow.add({}, spread(0.02), 0.0, kMost);
  wide.add({}, spread(0.3), 0.0, kMost);
  huge.add({}, spread(30.0), 0.0, kMost);
  EXPECT_LT(narrow.particle_count(), wide.particle_count());
  EXPECT_LE(huge.particle_count(), options.max_particles);
}

TEST(HypothesisFilter, ShrinksToThePoseTheScansTell) {
  const LikelihoodField field(square(), 1.0);
  const BeamModel model(field, BeamModelOptions{});
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  common::Pose2 truth{1.0, -2.0, 0.3};
  filter.add({1.2, -1.8, 0.35}, spread(0.3), 0.0, kMost);
  const int before = filter.particle_count();
  const common::Pose2 step{0.1, 0.0, 0.02};
  for (int i = 0; i < 15; ++i) {
    truth = truth * step;
    filter.move(step, Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal());
    filter.weigh(model, beams_from(truth), kMount);
  }
  const Hypothesis best = filter.hypotheses().front();
  EXPECT_NEAR(best.mean.x, truth.x, 0.1);
  EXPECT_NEAR(best.mean.y, truth.y, 0.1);
  EXPECT_NEAR(best.mean.theta, truth.theta, 0.05);
  EXPECT_LT(filter.particle_count(), before);
}

TEST(HypothesisFilter, KeepsTwoPlacesThatLookTheSameForever) {
  const LikelihoodField field(square(), 1.0);
  const BeamModel model(field, BeamModelOptions{});
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  common::Pose2 truth{1.0, -2.0, 0.3};
  filter.add(truth, spread(0.05), 0.0, kMost);
  filter.add({-1.0, 2.0, 0.3 - M_PI}, spread(0.05), 0.0, kMost);  // the square turned by half
  const common::Pose2 step{0.05, 0.0, 0.05};
  for (int i = 0; i < 200; ++i) {
    truth = truth * step;
    filter.move(step, Eigen::Vector3d(1e-5, 1e-5, 1e-5).asDiagonal());
    filter.weigh(model, beams_from(truth), kMount);
  }
  const auto hypotheses = filter.hypotheses();
  ASSERT_EQ(hypotheses.size(), 2U);
  EXPECT_LT(hypotheses.front().mass, 0.95);
}

TEST(HypothesisFilter, GivesUpAPlaceThatTheScansContradict) {
  const LikelihoodField field(square(), 1.0);
  const BeamModel model(field, BeamModelOptions{});
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  const common::Pose2 truth{1.0, -2.0, 0.3};
  filter.add({-3.0, 0.0, 0.3}, spread(0.05), 0.0, kMost);
  filter.add(truth, spread(0.05), std::log(0.1), kMost);
  for (int i = 0; i < 10; ++i) filter.weigh(model, beams_from(truth), kMount);
  const auto hypotheses = filter.hypotheses();
  ASSERT_EQ(hypotheses.size(), 1U);
  EXPECT_NEAR(hypotheses.front().mean.x, 1.0, 0.1);
}

TEST(HypothesisFilter, TakesNoMoreParticlesThanItIsTold) {
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  filter.add({}, spread(0.3), 0.0, 70);
  EXPECT_EQ(filter.particle_count(), 70);
  filter.add({1.0, 1.0, 0.0}, spread(0.3), 0.0, 7);
  EXPECT_EQ(filter.particle_count(), 77);
}

TEST(HypothesisFilter, GivesUpAPlaceWhoseBeamsWouldHaveGoneThroughWalls) {
  common::OccupancyGrid grid = square();
  // Two halves that look the same from the ends of the beams, and a screen in the right one.
  for (int row = 0; row < 100; ++row) grid.cells[static_cast<std::size_t>(row * 100 + 50)] = 100;
  for (int row = 30; row < 70; ++row) grid.cells[static_cast<std::size_t>(row * 100 + 75)] = 100;
  const LikelihoodField field(grid, 1.0);
  const BeamModel model(field, BeamModelOptions{});
  const common::Pose2 left{-3.0, 0.0, 0.0}, right{1.9, 0.0, 0.0};
  std::vector<Eigen::Vector2d> points;  // of the wall 3 m ahead
  for (int i = -20; i <= 20; ++i) points.emplace_back(3.05, 0.05 * i);
  EXPECT_NEAR(model.log_likelihood(points, left), model.log_likelihood(points, right), 1e-6);
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  filter.add(left, spread(0.02), 0.0, kMost);
  filter.add(right, spread(0.02), 0.0, kMost);
  for (int i = 0; i < 3; ++i) filter.weigh(model, points, kMount);
  EXPECT_NEAR(filter.hypotheses().front().mean.x, left.x, 0.1);
  EXPECT_GT(filter.hypotheses().front().mass, 0.99);
}

TEST(HypothesisFilter, JoinsPlacesThatMeetUnderTheOlderId) {
  const LikelihoodField field(square(), 1.0);
  const BeamModel model(field, BeamModelOptions{});
  HypothesisFilter filter(HypothesisFilterOptions{}, 1);
  const common::Pose2 truth{1.0, -2.0, 0.3};
  filter.add({1.15, -2.0, 0.3}, spread(0.01), 0.0, kMost);
  filter.add(truth, spread(0.01), 0.0, kMost);
  filter.weigh(model, beams_from(truth), kMount);
  ASSERT_EQ(filter.hypotheses().size(), 1U);
  EXPECT_EQ(filter.hypotheses().front().id, 0);
  EXPECT_NEAR(filter.hypotheses().front().mean.x, 1.0, 0.05);
}

LocalizationEvidence evidence(double seconds, double agreement, double mass = 1.0, int hypothesis = 0) {
  return {common::from_seconds(seconds), hypothesis, agreement, mass, 0.05, 0.1};
}

TEST(LocalizationMonitor, ClaimsASearchedPoseOnlyAfterTheSameHypothesisHeldWhileDriving) {
  LocalizationMonitorOptions options;
  options.confirm_distance = 0.5;
  LocalizationMonitor monitor{options};
  for (int i = 0; i < 5; ++i) {
    monitor.add(evidence(0.1 * i, 0.9));
    EXPECT_EQ(monitor.state(), TrackingState::kLost) << i;
  }
  monitor.add(evidence(0.5, 0.9, 1.0, 1));  // another one: begins anew
  for (int i = 0; i < 4; ++i) monitor.add(evidence(0.6 + 0.1 * i, 0.9, 1.0, 1));
  EXPECT_EQ(monitor.state(), TrackingState::kLost);
  for (int i = 0; i < 2; ++i) monitor.add(evidence(1.0 + 0.1 * i, 0.9, 1.0, 1));
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
}

TEST(LocalizationMonitor, WaitsForSeveralScansHoweverFastTheRobotDrives) {
  const LocalizationMonitorOptions options;
  LocalizationMonitor monitor{options};
  LocalizationEvidence fast = evidence(0.0, 0.9);
  fast.driven = 2.0;
  for (int i = 0; i < options.confirm_scans; ++i) {
    monitor.add(fast);
    EXPECT_EQ(monitor.state(), TrackingState::kLost) << i;
  }
  monitor.add(fast);
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
}

TEST(LocalizationMonitor, NeverClaimsAPoseThatIsNotMovedOn) {
  LocalizationMonitor monitor{LocalizationMonitorOptions{}};
  LocalizationEvidence standing = evidence(0.0, 1.0);
  standing.driven = 0.0;
  for (int i = 0; i < 1000; ++i) monitor.add(standing);
  EXPECT_EQ(monitor.state(), TrackingState::kLost);
}

TEST(LocalizationMonitor, IsUncertainWhileTwoHypothesesStandAndKeepsTrackingOverASmallDip) {
  LocalizationMonitor monitor{LocalizationMonitorOptions{}};
  monitor.trust();
  monitor.add(evidence(0.0, 0.9));
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  monitor.add(evidence(0.1, 0.55));
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  monitor.add(evidence(0.2, 0.45));
  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
  monitor.add(evidence(0.3, 0.55));
  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
  monitor.add(evidence(0.4, 0.9));
  EXPECT_EQ(monitor.state(), TrackingState::kTracking);
  monitor.add(evidence(0.5, 0.9, 0.6));
  EXPECT_EQ(monitor.state(), TrackingState::kUncertain);
}

TEST(LocalizationMonitor, IsLostWhenScansDisagreeForLongOrAnotherHypothesisTakesOver) {
  LocalizationMonitor disagreeing{LocalizationMonitorOptions{}};
  disagreeing.trust();
  for (int i = 0; i <= 10; ++i) disagreeing.add(evidence(0.1 * i, 0.1));
  EXPECT_EQ(disagreeing.state(), TrackingState::kLost);
  EXPECT_TRUE(disagreeing.just_lost());

  LocalizationMonitor overtaken{LocalizationMonitorOptions{}};
  overtaken.trust();
  overtaken.add(evidence(0.0, 0.9));
  overtaken.add(evidence(0.1, 0.9, 0.99, 1));
  EXPECT_EQ(overtaken.state(), TrackingState::kLost);
}

TEST(LocalizationPath, TellsInHindsightWhereItWasWhileItSearched) {
  LocalizationPath path(common::kKeepAll);
  const common::Pose2 step{1.0, 0.0, 0.0};
  path.add({1, {9.0, 9.0, 0.0}, 3, true, true}, {});
  path.add({2, {50.0, 0.0, 0.0}, 4, true, false}, step);  // held, but another one was thought better
  path.add({3, {2.02, 0.0, 0.0}, 7, true, false}, step);  // matched
  path.add({4, {3.0, 0.0, 0.0}, 7, true, true}, step);
  path.found_since(1);
  const auto trajectory = path.trajectory();
  ASSERT_EQ(trajectory.size(), 4U);
  EXPECT_EQ(trajectory[0].pose.x, 9.0) << "what was known stays";
  EXPECT_NEAR(trajectory[1].pose.x, 1.02, 1e-12);
  EXPECT_NEAR(trajectory[2].pose.x, 2.02, 1e-12);
}

TEST(LocalizationPath, TellsItInHindsightWhereItIsThinnedToo) {
  LocalizationPath path(200);
  constexpr int kScans = 5000;
  constexpr common::Nanoseconds kPeriod = 100'000'000;
  for (int i = 0; i < kScans; ++i) {
    const bool last = i + 1 == kScans;
    path.add({i * kPeriod, {last ? 1.0 * i : 0.0, 0.0, 0.0}, 7, last, last}, {1.0, 0.0, 0.0});
  }
  EXPECT_EQ(path.now(), static_cast<std::size_t>(kScans));
  path.found_since(1000);
  const auto trajectory = path.trajectory();
  EXPECT_LE(trajectory.size(), 200U);
  EXPECT_GT(trajectory.size(), 60U);
  EXPECT_GE(trajectory.front().stamp, 1000 * kPeriod);
  for (const auto& pose : trajectory) {
    EXPECT_NEAR(pose.pose.x, static_cast<double>(pose.stamp / kPeriod), 1e-9);
  }
}

TEST(LocalizationPath, TakesBackPosesSinceTheScansStoppedToAgree) {
  LocalizationPath path(common::kKeepAll);
  path.add({1, {}, 0, true, true}, {});
  path.add({2, {}, 0, false, true}, {});
  path.add({3, {}, 0, false, true}, {});
  path.lost();
  EXPECT_EQ(path.trajectory().size(), 1U);
}

}  // namespace
}  // namespace slamfuse::laser_slam
