// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/state.hpp"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace slamfuse::visual_slam {
namespace {

Eigen::Matrix3d some_covariance(double scale) {
  Eigen::Matrix3d root;
  root << 1.0, 0.2, -0.1, 0.0, 0.8, 0.3, 0.0, 0.0, 0.5;
  return scale * root * root.transpose();
}

class StateTest : public ::testing::Test {
 protected:
  StateTest() {
    robot_ = state_.append(Eigen::Vector3d(1.0, 2.0, 0.3), BlockKind::kPose, {}, some_covariance(0.01));
    calibration_ = state_.append(Eigen::Vector3d(0.01, 0.0, 0.0), BlockKind::kCalibration, {}, some_covariance(1e-4));
    const JacobianPart<Eigen::Dynamic> copy[] = {{robot_, Eigen::Matrix3d::Identity()}};
    clone_ = state_.append(state_.mean(robot_), BlockKind::kPose, copy, Eigen::Matrix3d::Zero());
    const JacobianPart<Eigen::Dynamic> from_robot[] = {{robot_, 0.7 * some_covariance(1.0)}};
    point_ = state_.append(Eigen::Vector3d(3.0, -1.0, 0.8), BlockKind::kPoint, from_robot, some_covariance(0.02));
  }

  State state_;
  BlockId robot_ = 0, calibration_ = 0, clone_ = 0, point_ = 0;
};

TEST_F(StateTest, ACopiedBlockIsFullyCorrelatedWithItsSource) {
  EXPECT_LT((state_.covariance(clone_, clone_) - state_.covariance(robot_, robot_)).norm(), 1e-15);
  EXPECT_LT((state_.covariance(clone_, robot_) - state_.covariance(robot_, robot_)).norm(), 1e-15);
}

TEST_F(StateTest, RemovingABlockLeavesTheOthersAsTheyWere) {
  const Eigen::Vector3d mean = state_.mean(point_);
  const Eigen::Matrix3d cross = state_.covariance(robot_, point_);
  const BlockId gone[] = {clone_};

  state_.remove(gone);

  EXPECT_EQ(state_.size(), 9);
  EXPECT_FALSE(state_.has(clone_));
  EXPECT_TRUE(state_.has(point_));
  EXPECT_EQ(Eigen::Vector3d(state_.mean(point_)), mean);
  EXPECT_EQ(Eigen::Matrix3d(state_.covariance(robot_, point_)), cross);
}

TEST_F(StateTest, GrowingOverManyBlocksKeepsTheCovarianceSymmetric) {
  std::vector<BlockId> blocks;
  const JacobianPart<Eigen::Dynamic> from_robot[] = {{robot_, Eigen::Matrix3d::Identity()}};
  for (int i = 0; i < 200; ++i) {
    blocks.push_back(state_.append(Eigen::Vector3d::Constant(i), BlockKind::kPoint, from_robot, some_covariance(1.0)));
  }
  std::vector<BlockId> odd;
  for (std::size_t i = 1; i < blocks.size(); i += 2) odd.push_back(blocks[i]);

  state_.remove(odd);

  EXPECT_EQ(state_.size(), 12 + 300);
  EXPECT_EQ(state_.mean(blocks[198])[0], 198.0);
  EXPECT_EQ((state_.covariance() - state_.covariance().transpose()).norm(), 0.0);
  EXPECT_LT((state_.covariance(blocks[198], robot_) - state_.covariance(robot_, robot_)).norm(), 1e-15);
}

TEST_F(StateTest, SubtractingAnOuterProductMatchesTheDenseFormula) {
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(state_.size(), 2);
  for (int i = 0; i < y.size(); ++i) y.data()[i] = 0.01 * (i % 5);
  const Eigen::MatrixXd expected = Eigen::MatrixXd(state_.covariance()) - y * y.transpose();

  state_.subtract_outer_product(y);

  EXPECT_LT((state_.covariance() - expected).norm(), 1e-15);
}

TEST_F(StateTest, AnErrorInCommonIsSharedByTheNumbersItIsOf) {
  const Eigen::MatrixXd before = state_.covariance();
  const Eigen::VectorXd mean = state_.mean();
  Eigen::VectorXd error = Eigen::VectorXd::Zero(state_.size());
  error[state_.offset(robot_)] = 0.2;
  error[state_.offset(point_) + 1] = -0.3;

  state_.add_error(error);

  const Eigen::MatrixXd grown = Eigen::MatrixXd(state_.covariance()) - before;
  EXPECT_NEAR(state_.covariance(robot_, robot_)(0, 0) - before(0, 0), 0.04, 1e-15);
  EXPECT_NEAR(grown(state_.offset(point_) + 1, state_.offset(robot_)), -0.06, 1e-15);
  EXPECT_LT((grown - error * error.transpose()).norm(), 1e-14) << "all others stay as they are";
  EXPECT_EQ(state_.mean(), mean);
}

TEST_F(StateTest, CorrectingOneBlockAloneTeachesTheOthersNothing) {
  const Eigen::Vector3d robot_before = state_.mean(robot_);
  const Eigen::Matrix3d robot_covariance = state_.covariance(robot_, robot_);
  const JacobianPart<1> jacobian[] = {{robot_, Eigen::RowVector3d(1, 0, 0)}, {point_, Eigen::RowVector3d(-1, 0, 0)}};
  const double before = state_.covariance(point_, point_)(0, 0);

  state_.correct_alone(point_, 0.1, jacobian, 1e-4);

  EXPECT_EQ(Eigen::Vector3d(state_.mean(robot_)), robot_before);
  EXPECT_EQ(Eigen::Matrix3d(state_.covariance(robot_, robot_)), robot_covariance);
  EXPECT_LT(state_.covariance(point_, point_)(0, 0), before);
  const Eigen::MatrixXd all = state_.covariance();
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(all).eigenvalues().minCoeff(), -1e-12);
}

/// The direction in which no measurement sees the map: all of it turned about the origin.
Eigen::VectorXd turn_direction(const State& state, std::span<const BlockId> positions, BlockId robot, BlockId clone) {
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(state.size());
  for (const BlockId block : positions) {
    direction[state.offset(block)] = -state.mean(block)[1];
    direction[state.offset(block) + 1] = state.mean(block)[0];
  }
  direction[state.offset(robot) + 2] = 1.0;
  direction[state.offset(clone) + 2] = 1.0;
  return direction;
}

TEST_F(StateTest, CorrectingTheMeanKeepsTheInformationAboutTheTurnOfTheWholeMap) {
  const BlockId positions[] = {robot_, clone_, point_};
  // The clone equals the robot; noise of its own makes the covariance invertible.
  const JacobianPart<Eigen::Dynamic> self[] = {{clone_, Eigen::Matrix3d::Identity()}};
  state_.transform(clone_, Eigen::Vector3d(0.5, 1.5, 0.2), BlockKind::kPose, self, 1e-4 * Eigen::Matrix3d::Identity());
  const Eigen::VectorXd before = turn_direction(state_, positions, robot_, clone_);
  const double information = before.dot(Eigen::MatrixXd(state_.covariance()).ldlt().solve(before));
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(state_.size());
  for (int i = 0; i < delta.size(); ++i) delta[i] = 0.05 * ((i * 7) % 5 - 2);
  delta[state_.offset(calibration_)] = 0.0;

  state_.correct(delta);

  const Eigen::VectorXd after = turn_direction(state_, positions, robot_, clone_);
  EXPECT_NEAR(after.dot(Eigen::MatrixXd(state_.covariance()).ldlt().solve(after)) / information, 1.0, 1e-6);
}

}  // namespace
}  // namespace slamfuse::visual_slam
