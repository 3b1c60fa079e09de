// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory_evaluation.hpp"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/angle.hpp"

namespace slamfuse::common {
namespace {

using testing::HasSubstr;

constexpr Nanoseconds kMillisecond = 1'000'000;
constexpr Nanoseconds kStart = 1'700'000'000 * kNanosecondsPerSecond;
/// Between the poses of the paths made here.
constexpr Nanoseconds kStep = 20 * kMillisecond;

/// Round a circle of 2 m radius at 1 m/s, a pose every 20 ms for `seconds`.
Trajectory2 circle(int seconds) {
  Trajectory2 trajectory;
  for (int i = 0; i <= seconds * 50; ++i) {
    const double turn = 0.02 * i / 2.0;
    trajectory.push_back({kStart + i * kStep,
                          {2.0 * std::cos(turn), 2.0 * std::sin(turn), normalize_angle(turn + std::numbers::pi / 2)}});
  }
  return trajectory;
}

/// Every fifth pose, moved to another frame.
Trajectory2 estimate_of(const Trajectory2& truth, const Similarity2& T_estimate_truth) {
  Trajectory2 estimate;
  for (std::size_t i = 0; i < truth.size(); i += 5) {
    estimate.push_back({truth[i].stamp, T_estimate_truth * truth[i].pose});
  }
  return estimate;
}

/// The part of a trajectory between two times in seconds from kStart, both included.
Trajectory2 part(const Trajectory2& trajectory, double from, double to) {
  Trajectory2 result;
  for (const StampedPose2& pose : trajectory) {
    const double t = to_seconds(pose.stamp - kStart);
    if (t >= from - 1e-9 && t <= to + 1e-9) result.push_back(pose);
  }
  return result;
}

TEST(EvaluateTrajectory, FindsNoErrorInAMovedCopy) {
  const Trajectory2 truth = circle(20);

  const auto accuracy = evaluate_trajectory(estimate_of(truth, {1.0, {100, -30, 2.5}}), truth);

  ASSERT_TRUE(accuracy.has_value()) << accuracy.error().message;
  EXPECT_NEAR(accuracy->ate_rmse_m, 0.0, 1e-9);
  EXPECT_NEAR(accuracy->ate_max_m, 0.0, 1e-9);
  EXPECT_NEAR(accuracy->heading_rmse_deg, 0.0, 1e-6);
  EXPECT_NEAR(accuracy->rpe_percent.value(), 0.0, 1e-9);
  EXPECT_DOUBLE_EQ(accuracy->coverage, 1.0);
  EXPECT_EQ(accuracy->errors.size(), 201u);
  EXPECT_EQ(accuracy->errors.front().stamp, kStart);
}

TEST(EvaluateTrajectory, NeedsSim2ForAPathOfAnotherScale) {
  const Trajectory2 truth = circle(20);
  const Trajectory2 estimate = estimate_of(truth, {4.0, {1, 2, -1}});

  const auto sim2 =
      evaluate_trajectory(estimate, truth, {.align = EvaluationAlignment::kSim2, .T_reference_estimate = {}});
  const auto se2 = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(sim2.has_value() && se2.has_value());
  EXPECT_NEAR(sim2->ate_rmse_m, 0.0, 1e-9);
  EXPECT_NEAR(sim2->rpe_percent.value(), 0.0, 1e-9);
  EXPECT_NEAR(sim2->T_reference_estimate.scale, 0.25, 1e-12);
  EXPECT_GT(se2->ate_rmse_m, 5.0);
}

TEST(EvaluateTrajectory, MeasuresAConstantShiftOnlyWithoutAlignment) {
  const Trajectory2 truth = circle(20);
  const Trajectory2 estimate = estimate_of(truth, {1.0, {0.3, 0.4, 0.0}});

  const auto none =
      evaluate_trajectory(estimate, truth, {.align = EvaluationAlignment::kNone, .T_reference_estimate = {}});
  const auto as = evaluate_trajectory(
      estimate, truth, {.align = EvaluationAlignment::kAs, .T_reference_estimate = {1.0, {-0.3, -0.4, 0.0}}});

  ASSERT_TRUE(none.has_value() && as.has_value());
  EXPECT_NEAR(none->ate_rmse_m, 0.5, 1e-12);
  EXPECT_NEAR(none->ate_max_m, 0.5, 1e-12);
  EXPECT_NEAR(none->rpe_percent.value(), 0.0, 1e-9);
  EXPECT_NEAR(as->ate_rmse_m, 0.0, 1e-12);
}

TEST(EvaluateTrajectory, MeasuresHeadingErrorsAcrossTheWrap) {
  const Trajectory2 truth = circle(20);
  Trajectory2 estimate = truth;
  for (StampedPose2& pose : estimate) pose.pose.theta = normalize_angle(pose.pose.theta - to_radians(3));

  const auto accuracy = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_NEAR(accuracy->heading_rmse_deg, 3.0, 1e-9);
  EXPECT_NEAR(accuracy->errors[200].heading, to_radians(-3), 1e-12);
}

TEST(EvaluateTrajectory, GivesTheRelativeErrorInPercentOfTheWay) {
  Trajectory2 truth;
  Trajectory2 estimate;
  for (int i = 0; i <= 1000; ++i) {
    truth.push_back({kStart + i * kStep, {0.02 * i, 0, 0}});
    estimate.push_back({truth.back().stamp, {0.02 * 1.03 * i, 0, 0}});
  }

  const auto accuracy = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_NEAR(accuracy->rpe_percent.value(), 3.0, 1e-9);
}

TEST(EvaluateTrajectory, HasNoRelativeErrorOnAShortPath) {
  const Trajectory2 truth = circle(4);

  const auto accuracy = evaluate_trajectory(truth, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_EQ(accuracy->rpe_percent, std::nullopt);
}

TEST(EvaluateTrajectory, InterpolatesTheReferenceButNotOverItsHoles) {
  Trajectory2 truth = part(circle(20), 0, 8);
  const Trajectory2 after = part(circle(20), 8.3, 20);
  truth.insert(truth.end(), after.begin(), after.end());
  // Half-way between two reference poses; 8.05 s lies within 0.1 s of only one of them.
  const Trajectory2 estimate = {
      {kStart + 1010 * kMillisecond, pose_at(truth, kStart + 1010 * kMillisecond, kMillisecond * 100).value()},
      {kStart + 8050 * kMillisecond, {50, 50, 0}},
      {kStart + 9000 * kMillisecond, pose_at(truth, kStart + 9000 * kMillisecond, 0).value()}};

  const auto accuracy = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_EQ(accuracy->errors.size(), 2u);
  EXPECT_NEAR(accuracy->ate_max_m, 0.0, 1e-9);
}

TEST(EvaluateTrajectory, ComparesAtEqualStampsOnlyWhenAsked) {
  const Trajectory2 truth = circle(20);
  Trajectory2 estimate = {truth[0], truth[100], truth[200]};
  estimate[1].stamp += 1;

  const auto accuracy = evaluate_trajectory(
      estimate, truth, {.align = EvaluationAlignment::kSe2, .T_reference_estimate = {}, .max_reference_gap = 0});

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_EQ(accuracy->errors.size(), 2u);
}

TEST(EvaluateTrajectory, FitsTheAlignmentBeforeTheFirstCarryOnly) {
  Trajectory2 truth = part(circle(20), 0, 10);
  Trajectory2 estimate = truth;
  // Carried 5 m away while there is no truth; the estimate believes it did not move.
  for (const StampedPose2& pose : part(circle(20), 10, 20)) {
    const Nanoseconds stamp = pose.stamp + 3 * kNanosecondsPerSecond;
    estimate.push_back({stamp, pose.pose});
    truth.push_back({stamp, {pose.pose.x + 5, pose.pose.y, pose.pose.theta}});
  }

  const auto accuracy = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_NEAR(accuracy->errors.front().position, 0.0, 1e-9);
  EXPECT_NEAR(accuracy->errors.back().position, 5.0, 1e-9);
  EXPECT_NEAR(accuracy->ate_rmse_m, 5.0 / std::sqrt(2.0), 0.01);
  EXPECT_NEAR(accuracy->rpe_percent.value(), 0.0, 1e-9) << "a sub-path spans the carry";
}

TEST(EvaluateTrajectory, TakesALongHoleWithoutAJumpAsNoCarry) {
  Trajectory2 truth = part(circle(20), 0, 0.1);
  for (const StampedPose2& pose : part(circle(20), 0.12, 20)) {
    truth.push_back({pose.stamp + 5 * kNanosecondsPerSecond, pose.pose});
  }
  Trajectory2 estimate = truth;
  for (std::size_t i = 6; i < estimate.size(); ++i) estimate[i].pose.x += 1.0;

  const auto accuracy = evaluate_trajectory(estimate, truth);

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_LT(accuracy->errors.back().position, 0.1) << "fitted on the first six poses alone";
}

TEST(EvaluateTrajectory, RefusesTrajectoriesWithoutTimeInCommon) {
  Trajectory2 late = circle(20);
  for (StampedPose2& pose : late) pose.stamp += 3600 * kNanosecondsPerSecond;

  const auto accuracy = evaluate_trajectory(late, circle(20));

  ASSERT_FALSE(accuracy.has_value());
  EXPECT_EQ(accuracy.error().kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(accuracy.error().message, HasSubstr("no time in common"));
  EXPECT_FALSE(evaluate_trajectory({}, circle(20)).has_value());
  EXPECT_FALSE(evaluate_trajectory(circle(20), {}).has_value());
}

TEST(EvaluateTrajectory, RefusesToAlignARobotThatStandsStill) {
  const Trajectory2 still = {{0, {1, 1, 0}}, {20 * kMillisecond, {1, 1, 0}}, {40 * kMillisecond, {1, 1, 0}}};

  const auto aligned = evaluate_trajectory(still, still);
  const auto unaligned =
      evaluate_trajectory(still, still, {.align = EvaluationAlignment::kNone, .T_reference_estimate = {}});

  ASSERT_FALSE(aligned.has_value());
  EXPECT_THAT(aligned.error().message, HasSubstr("expected at least two in different places"));
  ASSERT_TRUE(unaligned.has_value());
  EXPECT_EQ(unaligned->ate_rmse_m, 0.0);
}

TEST(EvaluateTrajectory, FitsTheOffsetOfAnotherBodyAndItsClock) {
  const Trajectory2 truth = circle(20);
  const Pose2 T_base_body{0.3, -0.1, 0.2};
  Trajectory2 tracked;
  for (const StampedPose2& pose : truth) tracked.push_back({pose.stamp, pose.pose * T_base_body});
  Trajectory2 estimate = estimate_of(truth, {1.0, {100, -30, 2.5}});
  for (StampedPose2& pose : estimate) pose.stamp += 70 * kMillisecond;
  EvaluationOptions options;

  const auto without = evaluate_trajectory(estimate, tracked, options);
  options.fit_offset = true;
  const auto fitted = evaluate_trajectory(estimate, tracked, options);

  ASSERT_TRUE(without && fitted);
  // On a circle a moved clock is a turned frame, so only the offset's size and the errors are determined.
  EXPECT_NEAR(fitted->ate_rmse_m, 0.0, 1e-3);
  EXPECT_NEAR(fitted->heading_rmse_deg, 0.0, 0.1);
  EXPECT_LT(fitted->ate_rmse_m, without->ate_rmse_m + 1e-9);

  options.align = EvaluationAlignment::kSim2;
  const auto refused = evaluate_trajectory(estimate, tracked, options);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
}

TEST(EvaluateTrajectory, FindsOffsetAndClockOnAPathThatTellsThem) {
  // Ahead with changing speed, and turning both ways.
  Trajectory2 truth;
  for (int i = 0; i <= 1000; ++i) {
    const double t = 0.02 * i;
    truth.push_back({kStart + i * kStep, {t + 0.5 * std::sin(t), 2.0 * std::sin(0.7 * t), std::sin(0.9 * t)}});
  }
  const Pose2 T_base_body{0.05, -0.02, 0.1};
  Trajectory2 tracked;
  for (const StampedPose2& pose : truth) tracked.push_back({pose.stamp, pose.pose * T_base_body});
  Trajectory2 estimate = estimate_of(truth, {1.0, {3, 4, -1.0}});
  for (StampedPose2& pose : estimate) pose.stamp += 50 * kMillisecond;
  EvaluationOptions options;
  options.fit_offset = true;

  const auto fitted = evaluate_trajectory(estimate, tracked, options);

  ASSERT_TRUE(fitted) << fitted.error().message;
  EXPECT_NEAR(to_seconds(fitted->clock_offset), -0.05, 0.002);
  EXPECT_NEAR(fitted->T_base_body.x, 0.05, 1e-3);
  EXPECT_NEAR(fitted->T_base_body.y, -0.02, 1e-3);
  EXPECT_NEAR(fitted->T_base_body.theta, 0.1, 1e-3);
  EXPECT_LT(fitted->ate_rmse_m, 1e-3);
}

}  // namespace
}  // namespace slamfuse::common
