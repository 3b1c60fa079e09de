// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/free_camera.hpp"

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/trajectory_evaluation.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/pose_block.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose3;

constexpr double kSeconds = 0.1;
constexpr common::Nanoseconds kFrame = 100'000'000;
constexpr std::size_t kFeatures = 40;

using Numbers = Eigen::Matrix<double, 8, 1>;
using Error = Eigen::Matrix<double, 14, 1>;  // of pose and numbers

MotionOptions free_camera() {
  MotionOptions options;
  options.model = MotionModelKind::kFreeCamera;
  return options;
}

/// The model's robot and numbers in a state of their own.
struct Model {
  explicit Model(const Pose3& pose, const Numbers& mean) {
    robot = motion.append_robot(state);
    numbers = motion.append_parameters(state);
    state.mean(robot) = free_pose_mean(pose);
    state.mean(numbers) = mean;
  }
  bool predict(double seconds = kSeconds) { return motion.predict(state, robot, numbers, {seconds, {}}); }

  FreeCamera motion{FreeCameraOptions{}};
  State state;
  BlockId robot = 0, numbers = 0;
};

const Pose3 kPose{{1.0, 2.0, 0.5}, rotation_exp({0.2, -0.3, 0.6})};
const Numbers kNumbers = (Numbers() << 0.0, 0.5, -0.1, 0.2, 0.3, -0.4, 0.8, 0.1).finished();

TEST(FreeCamera, ThePoseMovesOnWithTheVelocities) {
  Model model(kPose, kNumbers);

  EXPECT_TRUE(model.predict());

  const BodyPose way = displacement(*model.motion.twist(model.state, model.numbers), kSeconds);
  const BodyPose moved = body_pose(model.state, model.robot);
  EXPECT_LT((moved.position - kPose * way.position).norm(), 1e-12);
  EXPECT_LT((moved.rotation - BodyPose(kPose).rotation * way.rotation).norm(), 1e-12);
  EXPECT_EQ(model.state.mean(model.numbers), kNumbers);
  EXPECT_NEAR(model.motion.lever_scale(model.state, model.numbers), std::exp(0.1), 1e-12);
}

TEST(FreeCamera, NoTimeChangesNothing) {
  Model model(kPose, kNumbers);
  const Eigen::MatrixXd before = model.state.covariance();

  EXPECT_FALSE(model.predict(0.0));

  EXPECT_EQ(Eigen::MatrixXd(model.state.covariance()), before);
}

TEST(FreeCamera, TheErrorIsCarriedOnAsFiniteDifferencesSay) {
  constexpr double kStep = 1e-6;
  const auto error_after = [](const Error& error) {
    Model reference(kPose, kNumbers);
    reference.predict();
    const Pose3 pose{kPose.translation + error.head<3>(), rotation_exp(error.segment<3>(3)) * kPose.rotation};
    Model model(pose, kNumbers + error.tail<8>());
    model.predict();
    return Eigen::VectorXd(reference.state.error_given(model.state.mean()));
  };
  Eigen::Matrix<double, 14, 14> jacobian;
  for (int i = 0; i < 14; ++i) {
    jacobian.col(i) = (error_after(kStep * Error::Unit(i)) - error_after(-kStep * Error::Unit(i))) / (2.0 * kStep);
  }
  Model model(kPose, kNumbers);
  const Eigen::MatrixXd before = model.state.covariance();
  model.predict();
  const Eigen::MatrixXd after = model.state.covariance();

  // The velocities get their noise before the pose moves with them.
  const Eigen::MatrixXd noise = (after - before).bottomRightCorner<8, 8>();
  Eigen::MatrixXd with_noise = before;
  with_noise.bottomRightCorner<8, 8>() += noise;
  EXPECT_LT((after - jacobian * with_noise * jacobian.transpose()).norm(), 1e-8);
  EXPECT_GT(noise(1, 1), 0.0);
  EXPECT_GT(noise(6, 6), 0.0);
  EXPECT_EQ(noise(7, 7), 0.0);
}

TEST(FreeCamera, TheEstimateIsThePartOfThePoseInThePlane) {
  Model model(kPose, kNumbers);
  model.predict();
  constexpr double kStep = 1e-6;
  const common::Pose3 pose = spatial_pose(model.state, model.robot);
  Eigen::Matrix<double, 3, 6> jacobian;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Matrix<double, 6, 1> step = kStep * Eigen::Matrix<double, 6, 1>::Unit(i);
    const common::Pose3 moved{pose.translation + step.head<3>(), rotation_exp(step.tail<3>()) * pose.rotation};
    jacobian.col(i) = (common::to_pose2(moved).vector() - common::to_pose2(pose).vector()) / kStep;
  }

  const Eigen::Matrix3d expected = jacobian * model.state.covariance(model.robot, model.robot) * jacobian.transpose();
  EXPECT_LT((planar_covariance(model.state, model.robot) - expected).norm(), 1e-5 * expected.norm());
  EXPECT_EQ(planar_pose(model.state, model.robot).vector(), common::to_pose2(pose).vector());
}

TEST(FreeCamera, SettingThePoseInThePlaneKeepsHeightPitchAndRoll) {
  Model model(kPose, kNumbers);
  model.predict();
  const Eigen::Matrix3d covariance = Eigen::Vector3d(0.01, 0.02, 0.03).asDiagonal();
  const Pose3 before = spatial_pose(model.state, model.robot);

  set_planar_pose(model.state, model.robot, {5.0, -3.0, 2.5}, covariance);

  const Pose3 after = spatial_pose(model.state, model.robot);
  EXPECT_LT((common::to_pose2(after).vector() - Eigen::Vector3d(5.0, -3.0, 2.5)).norm(), 1e-12);
  EXPECT_EQ(after.translation.z(), before.translation.z());
  const Eigen::Vector3d up(0.0, 0.0, 1.0);
  EXPECT_LT((after.rotation.conjugate() * up - before.rotation.conjugate() * up).norm(), 1e-12);
  EXPECT_LT((planar_covariance(model.state, model.robot) - covariance).norm(), 1e-12);
}

/// A camera carried by hand through a room; it sees numbered points with noise.
class Walk {
 public:
  explicit Walk(unsigned seed) : noise_(seed), points_(testing::room_points(300, noise_)) {}

  /// Where it is after so many seconds, starting level at the origin: about a circle, nodding and swaying.
  static Pose3 at(double t) {
    const double turn = 0.25 * t;
    const Eigen::Quaterniond sway = rotation_exp({0.12 * std::sin(1.1 * t), 0.15 * std::sin(0.9 * t), 0.0});
    return {{1.2 * std::sin(turn), 1.2 * (1.0 - std::cos(turn)), 0.15 * std::sin(0.7 * t)},
            Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())) * sway};
  }

  void step(Ekf& filter) {
    stamp_ += kFrame;
    truth_ = at(common::to_seconds(stamp_));
    filter.predict({kSeconds, {}});
    look(filter);
    walked.push_back({stamp_, common::to_pose2(truth_)});
    estimated.push_back({stamp_, filter.pose()});
  }

  common::Trajectory2 walked;
  common::Trajectory2 estimated;
  const Pose3& truth() const { return truth_; }

 private:
  void look(Ekf& filter) {
    std::vector<Measurement> known, fresh;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto projection = project_cartesian(camera_, {}, truth_, points_[i]);
      if (!projection) continue;
      const auto pixel = camera_.calibration.project(projection->point.homogeneous());
      if (!pixel || !camera_.sees(*pixel, 5.0)) continue;
      const Eigen::Vector2d measured = *pixel + 0.5 * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
      const Measurement one{static_cast<LandmarkId>(i), make_bearing(camera_, measured, 0.5, BodyTwist())};
      if (filter.has(one.landmark)) {
        known.push_back(one);
      } else if (known.size() + fresh.size() < kFeatures) {
        fresh.push_back(one);
      }
    }
    const UpdateReport report = filter.update(camera_, known);
    std::vector<LandmarkId> accepted;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (report.accepted[i]) accepted.push_back(known[i].landmark);
    }
    filter.remove(filter.convert(camera_, accepted));
    for (const Measurement& one : fresh) filter.add_landmark(one.landmark, camera_, one.bearing, stamp_);
  }

  testing::Noise noise_;
  std::vector<Eigen::Vector3d> points_;
  Camera camera_ = testing::make_camera("cam0", 0.0);
  Pose3 truth_;
  common::Nanoseconds stamp_ = 0;
};

TEST(FreeCamera, BearingsAloneRecoverThePathUpToItsScaleAndHowTheCameraIsHeld) {
  for (const unsigned seed : {1U, 2U}) {
    Ekf filter({}, free_camera());
    Walk walk(seed);
    double tilt_square = 0.0;
    constexpr int kSteps = 250;
    for (int i = 0; i < kSteps; ++i) {
      walk.step(filter);
      const Eigen::Vector3d up = filter.spatial_pose().rotation.conjugate() * Eigen::Vector3d::UnitZ();
      tilt_square += (up - walk.truth().rotation.conjugate() * Eigen::Vector3d::UnitZ()).squaredNorm() / kSteps;
    }

    const auto accuracy = common::evaluate_trajectory(
        walk.estimated, walk.walked,
        {.align = common::EvaluationAlignment::kSim2, .T_reference_estimate = {}, .max_reference_gap = kFrame});
    ASSERT_TRUE(accuracy) << accuracy.error().message;
    EXPECT_LT(accuracy->ate_rmse_m, 0.1) << seed;
    EXPECT_LT(std::sqrt(tilt_square), common::to_radians(2.0)) << seed;
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
