// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/batch_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "common/median.hpp"
#include "visual_slam/bearing_simulation.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr double kPixelSigma = 1.0;

/// A robot that drives circles among points, with wheels that turn too much.
class BatchAdjustmentTest : public ::testing::Test {
 protected:
  BatchAdjustmentTest() : points_(testing::room_points(40, noise_)) {}

  /// Drives; each `wrong_every`th bearing is of another point (0: none).
  BatchAdjustment drive(double odometry_turns, int wrong_every = 0) {
    BatchAdjustment batch(options_);
    batch.start({});
    Pose2 believed;
    bearings_ = 0;
    for (std::size_t i = 0; i < path_.size(); ++i) {
      if (i > 0) {
        Eigen::Vector3d way = common::log_se2(path_[i - 1].inverse() * path_[i]);
        way.head<2>() += wheel_noise_ * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
        way.z() *= odometry_turns;
        believed = believed * common::exp_se2(way);
        batch.add_pose(common::exp_se2(way), believed);
      }
      for (std::size_t k = 0; k < points_.size(); ++k) {
        const auto seen = project_cartesian(camera_, {}, path_[i], points_[k]);
        if (!seen) continue;
        auto pixel = camera_.calibration.project(seen->point.homogeneous());
        if (!pixel || !camera_.sees(*pixel, 5.0)) continue;
        *pixel += kPixelSigma * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
        if (wrong_every > 0 && ++bearings_ % wrong_every == 0) pixel->x() += pixel->x() < 320.0 ? 60.0 : -60.0;
        batch.add_bearing(camera_, static_cast<LandmarkId>(k),
                          make_bearing(camera_, *pixel, kPixelSigma, Eigen::Vector3d::Zero()));
      }
    }
    return batch;
  }

  /// The points some decimetres off.
  std::map<LandmarkId, Eigen::Vector3d> guesses() {
    std::map<LandmarkId, Eigen::Vector3d> guesses;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      guesses[static_cast<LandmarkId>(k)] =
          points_[k] + 0.3 * Eigen::Vector3d(noise_.gaussian(), noise_.gaussian(), 0.3 * noise_.gaussian());
    }
    return guesses;
  }

  /// [m], of the landmarks; some are hardly ever seen, and their depth is anybody's guess.
  double median_error(const BatchAdjustment::Result& result) const {
    std::vector<double> errors;
    for (const auto& [id, place] : result.landmarks) {
      errors.push_back((place - points_[static_cast<std::size_t>(id)]).norm());
    }
    return common::median(std::move(errors));
  }

  testing::Noise noise_{4};
  MotionOptions options_;
  Camera camera_ = testing::make_camera("cam0", 0.6);
  std::vector<Pose2> path_ = testing::circle_path(220);
  std::vector<Eigen::Vector3d> points_;
  double wheel_noise_ = 0.002;  // [m] a step
  int bearings_ = 0;
};

TEST_F(BatchAdjustmentTest, FindsPathMapAndWhatTheWheelsDoWrong) {
  const auto result = drive(0.98).adjust(guesses());

  ASSERT_TRUE(result);
  EXPECT_GT(result->landmarks.size(), 30U);
  EXPECT_LT(median_error(*result), 0.04);
  EXPECT_LT((result->poses.back().translation() - path_.back().translation()).norm(), 0.03);
  EXPECT_NEAR(result->calibration[1] + result->calibration[2] * 0.08 / 0.06, 1.0 / 0.98 - 1.0, 0.005);
}

TEST_F(BatchAdjustmentTest, TheMapDoesNotShrinkToMakeRoomForTheOdometrysNoise) {
  wheel_noise_ = 0.0085;
  options_.distance_noise = options_.lateral_noise = 0.03;
  options_.distance_scale_sigma = 0.3;
  camera_ = testing::make_camera("cam0", 0.6, 0.0, 0.0);  // no lever arm: nothing but the odometry knows metres
  const auto result = drive(1.0).adjust(guesses());

  ASSERT_TRUE(result);
  EXPECT_NEAR(result->calibration[0], 0.0, 0.01);
  EXPECT_LT(median_error(*result), 0.08);
}

TEST_F(BatchAdjustmentTest, LeavesOutBearingsThatFitNothing) {
  const BatchAdjustment batch = drive(0.98, 40);
  const auto result = batch.adjust(guesses());

  ASSERT_TRUE(result);
  EXPECT_GE(result->wrong, bearings_ / 40);
  EXPECT_LT(result->wrong, bearings_ / 40 + bearings_ / 100);
  EXPECT_LT(median_error(*result), 0.04);
}

TEST_F(BatchAdjustmentTest, LeavesOutLandmarksWithTooFewBearings) {
  BatchAdjustment batch = drive(1.0);
  batch.add_bearing(camera_, 1000, make_bearing(camera_, {320.0, 240.0}, kPixelSigma, Eigen::Vector3d::Zero()));
  auto start = guesses();
  start[1000] = {3.0, 0.0, 0.7};

  const auto result = batch.adjust(start);

  ASSERT_TRUE(result);
  EXPECT_FALSE(result->landmarks.contains(1000));
}

}  // namespace
}  // namespace slamfuse::visual_slam
