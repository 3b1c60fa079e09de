// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/constant_velocity.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/trajectory_evaluation.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr double kSeconds = 0.2;
constexpr common::Nanoseconds kFrame = 200'000'000;
constexpr std::size_t kFeatures = 30;

MotionOptions constant_velocity() {
  MotionOptions options;
  options.model = MotionModelKind::kConstantVelocity;
  return options;
}

TEST(ConstantVelocity, ThePoseMovesOnWithTheSpeedAndTheTurnRate) {
  State state;
  const ConstantVelocity model({});
  const BlockId robot = state.append(Eigen::Vector3d(1.0, 2.0, 0.5), BlockKind::kPose, {}, Eigen::Matrix3d::Zero());
  const BlockId numbers = model.append_parameters(state);
  state.mean(numbers) << 0.0, 0.5, 0.3, 0.0;

  EXPECT_TRUE(model.predict(state, robot, numbers, {kSeconds, {}}));

  const Pose2 expected = Pose2{1.0, 2.0, 0.5} * common::exp_se2({0.1, 0.0, 0.06});
  EXPECT_LT((state.mean(robot) - expected.vector()).norm(), 1e-12);
  EXPECT_EQ(state.mean(numbers)[1], 0.5);
  EXPECT_GT(state.covariance(numbers, numbers)(1, 1), 0.0);
  EXPECT_GT(state.covariance(robot, numbers)(0, 1), 0.0) << "who drives faster gets further";
  EXPECT_GT(state.covariance(robot, numbers)(2, 2), 0.0);
}

TEST(ConstantVelocity, ItsSpeedInMetresKnowsWhatItHangsOn) {
  State state;
  const ConstantVelocity model({});
  model.append_robot(state);
  const BlockId numbers = model.append_parameters(state);
  state.mean(numbers) << 0.0, 0.5, 0.3, 0.2;
  const auto speed = model.metric_speed(state, numbers);
  ASSERT_TRUE(speed);
  EXPECT_NEAR(speed->value, 0.5 * std::exp(-0.2), 1e-12);
  for (int i = 0; i < 4; ++i) {
    constexpr double kStep = 1e-6;
    const double before = state.mean(numbers)[i];
    state.mean(numbers)[i] = before + kStep;
    EXPECT_NEAR(speed->wrt_parameters[i], (model.metric_speed(state, numbers)->value - speed->value) / kStep, 1e-5)
        << i;
    state.mean(numbers)[i] = before;
  }
}

TEST(ConstantVelocity, AMeasuredSpeedIsTakenWhenItIsPlausible) {
  Ekf filter({}, constant_velocity());
  filter.predict({kSeconds, {}});
  EXPECT_TRUE(filter.correct_speed(0.4, 0.01));
  EXPECT_NEAR(filter.twist()->linear.x() / filter.lever_scale(), 0.4, 0.01);
  filter.predict({kSeconds, {}});
  EXPECT_NEAR(filter.pose().x / filter.lever_scale(), 2 * 0.4 * kSeconds, 0.02) << "the pose knows of the speed";
  EXPECT_FALSE(filter.correct_speed(1.4, 0.01)) << "nobody gets as fast at once";
  EXPECT_NEAR(filter.twist()->linear.x() / filter.lever_scale(), 0.4, 0.02);
}

TEST(ConstantVelocity, WheelsNeedNobodyToTellTheSpeed) {
  Ekf filter({}, MotionOptions());
  filter.predict({kSeconds, {0.1, 0.0, 0.0}});
  EXPECT_FALSE(filter.correct_speed(0.2, 0.01));
  EXPECT_NEAR(filter.pose().x, 0.1, 1e-9);
}

TEST(ConstantVelocity, ASpeedThatIsToldIsHeldToLess) {
  ConstantVelocityOptions options;
  options.initial_speed_sigma = 0.0;
  options.initial_turn_rate_sigma = 0.0;
  const ConstantVelocity model(options);
  for (const bool told : {false, true}) {
    State state;
    const BlockId robot = model.append_robot(state);
    const BlockId numbers = model.append_parameters(state);
    ASSERT_TRUE(model.predict(state, robot, numbers, {.seconds = kSeconds, .odometry = {}, .speed_is_told = told}));
    const double noise = told ? options.told_speed_noise : options.speed_noise;
    EXPECT_NEAR(state.covariance(numbers, numbers)(1, 1), noise * noise * kSeconds, 1e-12) << told;
    const double turn_noise = common::to_radians(options.turn_rate_noise);
    EXPECT_NEAR(state.covariance(numbers, numbers)(2, 2), turn_noise * turn_noise * kSeconds, 1e-12) << told;
  }
  EXPECT_GT(options.told_speed_noise, options.speed_noise);
}

TEST(ConstantVelocity, NoTimeChangesNothing) {
  State state;
  const ConstantVelocity model({});
  const BlockId robot = state.append(Eigen::Vector3d::Zero(), BlockKind::kPose, {}, Eigen::Matrix3d::Zero());
  const BlockId numbers = model.append_parameters(state);
  const Eigen::MatrixXd before = state.covariance();

  EXPECT_FALSE(model.predict(state, robot, numbers, {}));

  EXPECT_EQ(Eigen::MatrixXd(state.covariance()), before);
}

/// Two cameras on a robot that drives curves in a room and sees numbered points with noise.
class Drive {
 public:
  explicit Drive(unsigned seed) : noise_(seed), points_(testing::room_points(300, noise_)) {}

  void step(Ekf& filter, const Eigen::Vector3d& twist) {
    truth_ = truth_ * common::exp_se2(kSeconds * twist);
    stamp_ += kFrame;
    filter.predict({kSeconds, {}});
    for (const Camera& camera : cameras_) look(filter, camera);
    driven.push_back({stamp_, truth_});
    estimated.push_back({stamp_, filter.pose()});
  }

  common::Trajectory2 driven;
  common::Trajectory2 estimated;

 private:
  void look(Ekf& filter, const Camera& camera) {
    std::vector<Measurement> known, fresh;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto projection = project_cartesian(camera, {}, truth_, points_[i]);
      if (!projection) continue;
      const auto pixel = camera.calibration.project(projection->point.homogeneous());
      if (!pixel || !camera.sees(*pixel, 5.0)) continue;
      const Eigen::Vector2d measured = *pixel + 0.5 * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
      const LandmarkId id = static_cast<LandmarkId>(i);
      const Measurement one{id, make_bearing(camera, measured, 1.0, Eigen::Vector3d::Zero())};
      if (filter.has(id)) {
        known.push_back(one);
      } else if (known.size() + fresh.size() < kFeatures) {
        fresh.push_back(one);
      }
    }
    const UpdateReport report = filter.update(camera, known);
    std::vector<LandmarkId> accepted;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (report.accepted[i]) accepted.push_back(known[i].landmark);
    }
    filter.remove(filter.convert(camera, accepted));
    for (const Measurement& one : fresh) filter.add_landmark(one.landmark, camera, one.bearing, stamp_);
  }

  testing::Noise noise_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Camera> cameras_ = {testing::make_camera("cam0", 0.6), testing::make_camera("cam1", -0.6, 0.1, -0.05)};
  Pose2 truth_;
  common::Nanoseconds stamp_ = 0;
};

TEST(ConstantVelocity, BearingsAloneRecoverThePathUpToItsScale) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Ekf filter({}, constant_velocity());
    Drive drive(seed);

    for (int i = 0; i < 200; ++i) {
      const double ramp = std::min(1.0, 0.1 * i);
      drive.step(filter, {0.4 * ramp, 0.0, ramp * (i % 60 < 30 ? 0.5 : 0.1)});
    }

    const auto accuracy = common::evaluate_trajectory(
        drive.estimated, drive.driven,
        {.align = common::EvaluationAlignment::kSim2, .T_reference_estimate = {}, .max_reference_gap = kFrame});
    ASSERT_TRUE(accuracy) << accuracy.error().message;
    EXPECT_LT(accuracy->ate_rmse_m, 0.1) << seed;
    EXPECT_NEAR(accuracy->T_reference_estimate.scale * filter.lever_scale(), 1.0, 0.15)
        << "turning on a known lever arm tells how long a metre is";
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
