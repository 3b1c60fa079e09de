// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/consensus.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

/// Measurements that share one uncertain shift of 10 and have noise of 1 each.
Eigen::MatrixXd shared_shift_covariance(int count) {
  Eigen::MatrixXd shift = Eigen::MatrixXd::Zero(2 * count, 2);
  for (int i = 0; i < count; ++i) shift.middleRows<2>(2 * i) = 10.0 * Eigen::Matrix2d::Identity();
  return shift * shift.transpose() + Eigen::MatrixXd::Identity(2 * count, 2 * count);
}

const double kGate = chi_square_gate_2(0.99);

TEST(Consensus, TheGateIsTheChiSquareQuantileOfTwoDegreesOfFreedom) {
  EXPECT_NEAR(chi_square_gate_2(0.95), 5.991, 1e-3);
  EXPECT_NEAR(chi_square_gate_2(0.99), 9.210, 1e-3);
}

TEST(Consensus, AgreeingMeasurementsAreAllAccepted) {
  Eigen::VectorXd innovation(8);
  innovation << 5.0, 3.0, 5.5, 2.5, 4.6, 3.3, 5.1, 3.1;

  const Consensus consensus = find_consensus(innovation, shared_shift_covariance(4), kGate);

  EXPECT_THAT(consensus.accepted, ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_LT(consensus.mean_nis, 1.5);
}

TEST(Consensus, AnOutlierInsideItsOwnGateIsLeftOutBecauseTheOthersContradictIt) {
  Eigen::VectorXd innovation(8);
  innovation << 5.0, 3.0, -6.0, 2.5, 4.6, 3.3, 5.1, 3.1;
  const Eigen::MatrixXd covariance = shared_shift_covariance(4);
  ASSERT_LT(36.0 / covariance(2, 2), kGate);

  const Consensus consensus = find_consensus(innovation, covariance, kGate);

  EXPECT_THAT(consensus.accepted, ::testing::ElementsAre(0, 2, 3));
}

TEST(Consensus, ANoticeableMinorityOfOutliersDoesNotWin) {
  Eigen::VectorXd innovation(20);
  for (int i = 0; i < 10; ++i) {
    const double shift = i < 6 ? 4.0 : -4.0 - 3.0 * i;
    innovation.segment<2>(2 * i) << shift, 1.0;
  }

  const Consensus consensus = find_consensus(innovation, shared_shift_covariance(10), kGate);

  EXPECT_THAT(consensus.accepted, ::testing::ElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(Consensus, NothingPassesWhenEverythingIsFarOff) {
  const Eigen::VectorXd innovation = Eigen::VectorXd::Constant(6, 500.0);

  const Consensus consensus = find_consensus(innovation, shared_shift_covariance(3), kGate);

  EXPECT_TRUE(consensus.accepted.empty());
  EXPECT_EQ(consensus.mean_nis, 0.0);
}

TEST(Consensus, NoMeasurementsGiveNoConsensus) {
  EXPECT_TRUE(find_consensus(Eigen::VectorXd(), Eigen::MatrixXd(), kGate).accepted.empty());
}

}  // namespace
}  // namespace slamfuse::visual_slam
