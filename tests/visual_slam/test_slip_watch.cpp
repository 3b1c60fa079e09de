// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/slip_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/LU>

#include "visual_slam/consensus.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using Verdict = SlipWatch::Verdict;
using BySlip = Eigen::Matrix<double, Eigen::Dynamic, 2>;

constexpr double kGate = 9.21;

/// Innovations of so many bearings with unit noise that all move with the slip.
struct Bearings {
  explicit Bearings(int count) : innovations(2 * count), by_slip(2 * count, 2) {
    testing::Noise noise(3);
    for (int i = 0; i < 2 * count; ++i) {
      innovations[i] = noise.gaussian();
      by_slip.row(i) << 1.0 + noise.uniform(), noise.uniform() - 0.5;
    }
  }
  SlipEvidence evidence(const Eigen::Vector2d& slip) const {
    return slip_evidence(innovations + by_slip * slip,
                         Eigen::MatrixXd::Identity(innovations.size(), innovations.size()), by_slip, kGate);
  }
  Eigen::VectorXd innovations;
  BySlip by_slip;
};

TEST(SlipEvidence, IsTheRatioOfTheDensities) {
  const Bearings bearings(12);
  const Eigen::MatrixXd narrow = Eigen::MatrixXd::Identity(24, 24);
  const Eigen::MatrixXd wide = narrow + bearings.by_slip * bearings.by_slip.transpose();
  const Eigen::VectorXd innovations = bearings.innovations + bearings.by_slip * Eigen::Vector2d(-0.8, 0.4);
  ASSERT_EQ(find_consensus(innovations, wide, kGate).accepted.size(), 12U);

  const double expected = innovations.dot(narrow.inverse() * innovations) -
                          innovations.dot(wide.inverse() * innovations) -
                          std::log(wide.determinant() / narrow.determinant());

  EXPECT_NEAR(bearings.evidence({-0.8, 0.4}).evidence, expected, 1e-9);
}

TEST(SlipEvidence, SpeaksForSlipOnlyWhenThereIsSome) {
  const Bearings bearings(30);
  EXPECT_LT(bearings.evidence({0.0, 0.0}).evidence, 0.0);
  EXPECT_GT(bearings.evidence({1.0, 0.0}).evidence, 10.0);
  EXPECT_GT(bearings.evidence({1.0, 0.0}).share, 0.5);
  EXPECT_LT(bearings.evidence({-1.0, 0.0}).share, -0.5);
}

TEST(SlipEvidence, NeedsWitnesses) { EXPECT_EQ(Bearings(4).evidence({1.0, 0.0}).evidence, 0.0); }

SlipWatch moving() {
  SlipWatch watch;
  watch.move({Eigen::Matrix<double, 3, 2>::Ones(), Eigen::Matrix2d::Identity()}, {0.1, 0.0}, 0.2);
  return watch;
}

Verdict judge_images(SlipWatch& watch, int images, double evidence, double share = -0.8) {
  Verdict last = Verdict::kNothing;
  for (int i = 0; i < images && last == Verdict::kNothing; ++i) {
    watch.move({Eigen::Matrix<double, 3, 2>::Ones(), Eigen::Matrix2d::Identity()}, {0.1, 0.0}, 0.2);
    last = watch.judge({evidence, share});
    watch.next_image();
  }
  return last;
}

TEST(SlipWatch, BelievesInSlipAfterSomeImagesAndInGripAfterSomeMore) {
  SlipWatch watch;
  EXPECT_EQ(judge_images(watch, 10, -3.0), Verdict::kNothing);
  EXPECT_FALSE(watch.doubtful());
  EXPECT_EQ(judge_images(watch, 2, 6.0), Verdict::kNothing);
  EXPECT_EQ(judge_images(watch, 1, 6.0), Verdict::kSlip);
  EXPECT_TRUE(watch.doubtful());
  EXPECT_EQ(judge_images(watch, 10, -3.0), Verdict::kNothing);
  EXPECT_TRUE(watch.doubtful()) << "it goes on";
  EXPECT_EQ(judge_images(watch, 3, 6.0, -0.8), Verdict::kNothing) << "that is more slip, no grip";
  EXPECT_EQ(judge_images(watch, 1, 6.0, 0.8), Verdict::kGrip);
  EXPECT_FALSE(watch.doubtful());
}

TEST(SlipWatch, OneImageDoesNotDecide) {
  SlipWatch watch = moving();
  EXPECT_EQ(judge_images(watch, 1, 1000.0), Verdict::kNothing);
  EXPECT_EQ(judge_images(watch, 10, -3.0), Verdict::kNothing);
}

TEST(SlipWatch, ARobotThatMovesMoreThanItsWheelsSayIsNoSlipButDoubtful) {
  SlipWatch watch;
  EXPECT_EQ(judge_images(watch, 10, 6.0, 0.8), Verdict::kNothing);
  EXPECT_TRUE(watch.doubtful());
}

TEST(SlipWatch, EndsASlipThatLastsTooLong) {
  SlipWatch watch;
  ASSERT_EQ(judge_images(watch, 3, 6.0), Verdict::kSlip);
  judge_images(watch, 55, -3.0);
  EXPECT_FALSE(watch.doubtful());
}

TEST(SlipWatch, DoubtsWhatItDoesNotBelieveToBeSlipAgainSoSoon) {
  SlipWatch watch;
  judge_images(watch, 3, 6.0);
  judge_images(watch, 3, 6.0, 0.8);
  EXPECT_EQ(judge_images(watch, 10, 6.0), Verdict::kNothing);
  EXPECT_TRUE(watch.doubtful());
  EXPECT_EQ(judge_images(watch, 20, -3.0), Verdict::kNothing);
  EXPECT_FALSE(watch.doubtful());
}

TEST(SlipWatch, ATurnTurnsTheWayAfterIt) {
  SlipWatch watch;
  Slip turn{Eigen::Matrix<double, 3, 2>::Zero(), Eigen::Matrix2d::Identity()};
  turn.pose(2, 1) = 0.1;
  watch.move(turn, {0.0, 0.0}, 0.1);
  watch.move({Eigen::Matrix<double, 3, 2>::Zero(), Eigen::Matrix2d::Identity()}, {2.0, 0.0}, 0.1);
  EXPECT_NEAR(watch.since_image()->pose(1, 1), 0.2, 1e-12);
}

}  // namespace
}  // namespace slamfuse::visual_slam
