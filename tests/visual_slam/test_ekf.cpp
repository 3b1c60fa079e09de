// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/ekf.hpp"

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;
using testing::make_camera;
using testing::Noise;

constexpr double kPixelSigma = 1.0;
constexpr common::Nanoseconds kFrame = 200'000'000;
constexpr std::size_t kFeatures = 25;

/// A robot driving circles in a room, its cameras seeing numbered points with noise, its odometry with the noise and
/// the systematic errors that the options promise.
class Simulation {
 public:
  Simulation(unsigned seed, int cameras) : noise_(seed), points_(testing::room_points(300, noise_)) {
    if (cameras > 0) cameras_.push_back(make_camera("cam0", 0.6));
    if (cameras > 1) cameras_.push_back(make_camera("cam1", -0.6, 0.1, -0.05));
    calibration_ = {motion_.distance_scale_sigma * noise_.gaussian(), motion_.turn_scale_sigma * noise_.gaussian(),
                    common::to_radians(motion_.turn_per_distance_sigma) * noise_.gaussian()};
  }

  /// Drives one frame on, and returns the true pose in the map.
  const Pose2& step(Ekf& filter) {
    drive(filter);
    for (const Camera& camera : cameras_) look(filter, camera);
    stamp_ += kFrame;
    return truth_;
  }

  const Pose2& truth() const { return truth_; }
  int outliers_every = 0;  ///< each so many measurements one is wrong; 0 = none
  int outliers_made = 0;
  int outliers_accepted = 0;

 private:
  /// The measured increment whose calibrated value, with noise, is the true one: truth is drawn from the model.
  void drive(Ekf& filter) {
    const Pose2 measured = common::exp_se2({0.08, 0.0, 0.06});
    const CalibratedIncrement step = calibrate_increment(measured, calibration_, motion_);
    const Eigen::Vector3d sigma = step.noise.diagonal().cwiseSqrt();
    truth_ = truth_ * Pose2{step.increment.x + sigma.x() * noise_.gaussian(),
                            step.increment.y + sigma.y() * noise_.gaussian(),
                            step.increment.theta + sigma.z() * noise_.gaussian()};
    filter.predict({common::to_seconds(kFrame), measured});
  }

  void look(Ekf& filter, const Camera& camera) {
    std::vector<Measurement> known;
    std::vector<Measurement> fresh;
    std::vector<bool> wrong;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto projection = project_cartesian(camera, {}, truth_, points_[i]);
      if (!projection) continue;
      const auto pixel = camera.calibration.project(projection->point.homogeneous());
      if (!pixel || !camera.sees(*pixel, 5.0)) continue;
      Eigen::Vector2d measured = *pixel + kPixelSigma * Eigen::Vector2d(noise_.gaussian(), noise_.gaussian());
      const LandmarkId id = static_cast<LandmarkId>(i);
      const bool is_known = filter.has(id);
      wrong.push_back(is_known && outliers_every > 0 && ++count_ % outliers_every == 0);
      if (wrong.back()) measured += Eigen::Vector2d(40.0, -25.0);
      const Measurement measurement{id, make_bearing(camera, measured, kPixelSigma, Eigen::Vector3d::Zero())};
      if (is_known) {
        known.push_back(measurement);
      } else {
        wrong.pop_back();
        if (known.size() + fresh.size() < kFeatures) fresh.push_back(measurement);
      }
    }
    const UpdateReport report = filter.update(camera, known);
    std::vector<LandmarkId> accepted;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (report.accepted[i]) accepted.push_back(known[i].landmark);
      if (wrong[i]) {
        ++outliers_made;
        outliers_accepted += report.accepted[i] ? 1 : 0;
      }
    }
    filter.remove(filter.convert(camera, accepted));
    for (const Measurement& measurement : fresh) {
      filter.add_landmark(measurement.landmark, camera, measurement.bearing, stamp_);
    }
  }

  Noise noise_;
  MotionOptions motion_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Camera> cameras_;
  OdometryCalibration calibration_;
  Pose2 truth_;
  common::Nanoseconds stamp_ = 0;
  int count_ = 0;
};

FilterOptions filter_options() {
  FilterOptions options;
  options.pixel_sigma = kPixelSigma;
  return options;
}

Eigen::Vector3d error_of(const Ekf& filter, const Pose2& truth) {
  const Pose2 pose = filter.pose();
  return {truth.x - pose.x, truth.y - pose.y, common::angle_difference(truth.theta, pose.theta)};
}

TEST(Ekf, StartsAtTheOriginOfItsMap) {
  const Ekf filter(filter_options(), {});

  EXPECT_EQ(filter.pose().vector().norm(), 0.0);
  EXPECT_LT(filter.pose_covariance().norm(), 1e-6);
}

TEST(Ekf, ALandmarkStartsOnItsRayAtTheInitialDepthAndIsPredictedWhereItWasSeen) {
  Ekf filter(filter_options(), {});
  const Camera camera = make_camera("cam0", 0.4);
  const Bearing bearing = make_bearing(camera, {200.0, 300.0}, kPixelSigma, Eigen::Vector3d::Zero());

  filter.add_landmark(7, camera, bearing, 1);

  const std::optional<Prediction> prediction = filter.predict_bearing(camera, 7, {});
  ASSERT_TRUE(prediction);
  EXPECT_LT((prediction->point - bearing.point).norm(), 1e-9);
  EXPECT_FALSE(filter.map_point(7));
  EXPECT_EQ(filter.past_poses().size(), 1U);
}

TEST(Ekf, TheAnchorPoseGoesWithItsLastLandmark) {
  Ekf filter(filter_options(), {});
  const Camera camera = make_camera("cam0", 0.4);
  const int size = filter.state().size();
  filter.add_landmark(1, camera, make_bearing(camera, {200.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 1);
  filter.add_landmark(2, camera, make_bearing(camera, {400.0, 300.0}, 1.0, Eigen::Vector3d::Zero()), 1);
  EXPECT_EQ(filter.state().size(), size + 9);
  const LandmarkId both[] = {1, 2};

  filter.remove(both);

  EXPECT_EQ(filter.state().size(), size);
  EXPECT_TRUE(filter.past_poses().empty());
}

TEST(Ekf, VisionKeepsTheErrorFarBelowThatOfTheOdometry) {
  Simulation seeing(3, 1), blind(3, 0);
  Ekf with_camera(filter_options(), {}), odometry_only(filter_options(), {});

  for (int i = 0; i < 200; ++i) {
    seeing.step(with_camera);
    blind.step(odometry_only);
  }

  const double by_vision = error_of(with_camera, seeing.truth()).head<2>().norm();
  EXPECT_LT(by_vision, 0.1);
  EXPECT_LT(with_camera.pose_covariance()(2, 2), 0.05 * odometry_only.pose_covariance()(2, 2));
}

TEST(Ekf, LandmarksBecomeCartesianNearTheirTruePlaces) {
  Simulation simulation(5, 2);
  Ekf filter(filter_options(), {});
  for (int i = 0; i < 100; ++i) simulation.step(filter);

  int cartesian = 0;
  for (LandmarkId id = 0; id < 300; ++id) {
    if (filter.has(id) && filter.map_point(id)) ++cartesian;
  }

  EXPECT_GT(cartesian, 30);
}

TEST(Ekf, TwoCamerasAreBetterThanOneThroughTheSameInterface) {
  double one = 0.0, two = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Simulation with_one(seed, 1), with_two(seed, 2);
    Ekf filter_one(filter_options(), {}), filter_two(filter_options(), {});
    for (int i = 0; i < 120; ++i) {
      with_one.step(filter_one);
      with_two.step(filter_two);
    }
    one += filter_one.pose_covariance().topLeftCorner<2, 2>().trace();
    two += filter_two.pose_covariance().topLeftCorner<2, 2>().trace();
  }
  EXPECT_LT(two, one);
}

TEST(Ekf, WrongMatchesDoNotEnter) {
  Simulation simulation(11, 2);
  simulation.outliers_every = 8;
  Ekf filter(filter_options(), {});

  for (int i = 0; i < 100; ++i) simulation.step(filter);

  ASSERT_GT(simulation.outliers_made, 100);
  EXPECT_LT(simulation.outliers_accepted, simulation.outliers_made / 20);
  EXPECT_LT(error_of(filter, simulation.truth()).head<2>().norm(), 0.15);
}

TEST(Ekf, TheErrorStaysWithinAFewStandardDeviationsOverManyRuns) {
  constexpr int kRuns = 12;
  double nees = 0.0;
  int samples = 0;
  for (unsigned seed = 100; seed < 100 + kRuns; ++seed) {
    Simulation simulation(seed, 1);
    Ekf filter(filter_options(), {});
    for (int i = 0; i < 150; ++i) {
      simulation.step(filter);
      if (i % 30 != 29) continue;
      const Eigen::Vector3d error = error_of(filter, simulation.truth());
      nees += error.dot(filter.pose_covariance().inverse() * error);
      ++samples;
    }
  }
  // Three degrees of freedom would give 3. It is about 6.5 here: the filter is overconfident by half its standard
  // deviation (README, limits). The test holds that it gets no worse.
  EXPECT_GT(nees / samples, 1.2);
  EXPECT_LT(nees / samples, 8.0);
}

TEST(Ekf, KeyframesStayWithinTheirLimit) {
  Ekf filter(filter_options(), {});

  for (int i = 0; i < 50; ++i) {
    filter.predict({common::to_seconds(kFrame), {0.1, 0.0, 0.0}});
    filter.add_keyframe(i * kFrame, 10);
  }

  EXPECT_EQ(filter.past_poses().size(), 10U);
  EXPECT_EQ(filter.past_poses().front().stamp, 0);
  EXPECT_EQ(filter.past_poses().back().stamp, 49 * kFrame);
}

TEST(Ekf, SettingThePoseKeepsTheMapAndForgetsWhatHasNoDepth) {
  Simulation simulation(5, 1);
  Ekf filter(filter_options(), {});
  for (int i = 0; i < 60; ++i) simulation.step(filter);
  const std::size_t before = filter.landmark_count();

  const std::vector<LandmarkId> gone = filter.set_pose({1.0, 2.0, 0.5}, 0.01 * Eigen::Matrix3d::Identity());

  EXPECT_NEAR(filter.pose().x, 1.0, 1e-12);
  EXPECT_NEAR(filter.pose_covariance()(0, 0), 0.01, 1e-12);
  EXPECT_EQ(filter.landmark_count(), before - gone.size());
  for (LandmarkId id = 0; id < 300; ++id) {
    EXPECT_TRUE(!filter.has(id) || filter.is_cartesian(id));
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
