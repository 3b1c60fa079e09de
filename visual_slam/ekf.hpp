// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/pose2.hpp"
#include "common/pose3.hpp"
#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/landmark_initialisation.hpp"
#include "visual_slam/measurement_model.hpp"
#include "visual_slam/motion_model.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/past_poses.hpp"
#include "visual_slam/pose_block.hpp"
#include "visual_slam/slip_admission.hpp"
#include "visual_slam/slip_watch.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

using LandmarkId = std::int64_t;

/// A landmark measured in an image.
struct Measurement {
  LandmarkId landmark = 0;
  Bearing bearing;
};

/// What an update did.
struct UpdateReport {
  std::vector<bool> accepted;  ///< for each measurement
  int inliers = 0;
  double mean_nis = 0.0;                                     ///< of the accepted ones, per degree of freedom
  SlipWatch::Verdict wheels = SlipWatch::Verdict::kNothing;  ///< whether they have begun to slip or to grip again
};

/// The extended Kalman filter: robot pose, systematic odometry errors, past poses and landmarks in one dense state.
/// It knows bearings and landmark numbers only, no images: bearings given by hand drive it as well.
class Ekf {
 public:
  Ekf(const FilterOptions& filter, const MotionOptions& motion);

  /// base_link in the plane; of a free camera's pose the part in the plane.
  common::Pose2 pose() const { return planar_pose(state_, robot_); }
  Eigen::Matrix3d pose_covariance() const { return planar_covariance(state_, robot_); }
  /// Whether it knows of the plane only.
  bool is_planar() const { return state_.kind(robot_) == BlockKind::kPose; }
  /// base_link with height, pitch and roll, which are 0 in a planar filter.
  common::Pose3 spatial_pose() const { return visual_slam::spatial_pose(state_, robot_); }
  /// The numbers of the motion model: for odometry, the OdometryCalibration.
  Eigen::VectorXd motion_parameters() const { return state_.mean(motion_parameters_); }
  /// How base_link moves, where the motion model knows it.
  std::optional<BodyTwist> twist() const { return motion_->twist(state_, motion_parameters_); }
  /// Whether the wheel odometry contradicts the camera: the wheels slip, or its systematic errors would have to be
  /// larger than the options allow (or the camera's calibration is wrong). The estimate may be off by more than its
  /// covariance then.
  bool odometry_is_doubtful() const;
  /// Whether the map's unit is a metre: by the motion model, or because somebody tells the speed in metres.
  bool is_metric() const { return motion_->is_metric() || metres_are_told_; }
  /// From now on, or from now on not, the speed is told in metres (correct_speed). Landmarks of unknown depth teach the
  /// robot no speed then.
  void set_metres_are_told(bool told) { metres_are_told_ = told; }
  /// How many units of the map a metre is.
  double lever_scale() const { return motion_->lever_scale(state_, motion_parameters_); }
  /// Optical centre of a camera in the map.
  Eigen::Vector3d camera_centre(const Camera& camera) const {
    return optical_centre(camera, body_pose(state_, robot_), lever_scale());
  }
  const State& state() const { return state_; }
  const std::vector<PastPose>& past_poses() const { return past_poses_.all(); }
  common::Pose2 past_pose(const PastPose& past) const { return planar_pose(state_, past.block); }
  common::Pose3 spatial_past_pose(const PastPose& past) const { return visual_slam::spatial_pose(state_, past.block); }
  /// The keyframe of that stamp; null when there is none.
  const PastPose* keyframe_at(common::Nanoseconds stamp) const { return past_poses_.keyframe_at(stamp); }
  bool has(LandmarkId landmark) const { return landmarks_.contains(landmark); }
  std::size_t landmark_count() const { return landmarks_.size(); }
  bool is_cartesian(LandmarkId landmark) const { return !landmarks_.at(landmark).anchored(); }

  /// Moves the robot as the motion model says.
  void predict(const MotionStep& step);
  /// Where a landmark should appear in an image taken now; empty when it is behind the camera.
  std::optional<Prediction> predict_bearing(const Camera& camera, LandmarkId landmark, const BodyPose& row_shift) const;
  /// The same for a point that is not in the filter, the correlation of its error with the pose's taken for zero.
  std::optional<Prediction> predict_point(const Camera& camera, const MapPoint& point, const BodyPose& row_shift) const;
  /// Corrects everything by the bearings of one image. Bearings that do not fit are left out (find_consensus).
  ///
  /// While the depth of a landmark is poorly known, only the part of its bearing across the epipolar line corrects the
  /// whole state; the part along it, the parallax, teaches the landmark its depth and nothing else. A plain EKF lets
  /// both learn from the product of unknown depth and driven distance, linearised at a wrong depth; the errors do not
  /// average out and shrink the scale of the map image by image (25 % on a 68 m corridor).
  ///
  /// Landmarks that wait for a well-conditioned pair correct nothing: their bearing is accepted when it fits the
  /// epipolar line, and when the pair with their first sight passes the test of seed 000 section II.E they enter as
  /// points.
  ///
  /// Bearings are taken for MotionModel::bearing_margin times as noisy as their sigma says, here and in add_landmark().
  UpdateReport update(const Camera& camera, std::span<const Measurement> measurements);
  /// Enters a landmark seen the first time: by inverse depth, undelayed (seed 002 section 2.3), or, as the options
  /// say, to wait for a well-conditioned pair. Its inverse depth starts at the median of the landmarks of known depth
  /// the last update accepted, which must have been of the same image, or, where they are too few, at a fixed value.
  /// `stamp` is that of the image; landmarks of one stamp share their anchor. The camera must outlive the landmark.
  void add_landmark(LandmarkId landmark, const Camera& camera, const Bearing& bearing, common::Nanoseconds stamp);
  /// Enters a landmark of a saved map: it helps to find the pose but is not estimated. Its uncertainty enters as noise
  /// of its measurements (Schmidt's consider filter with the correlation between pose and map left out: a saved map has
  /// none), so the state does not grow (seed 000 section G).
  void add_fixed_landmark(LandmarkId landmark, const MapPoint& point);
  /// What is not known of a landmark's place even if the past pose were known exactly: the covariance of its error less
  /// what the error of the past pose makes of it, in the map's axes.
  Eigen::Matrix3d covariance_given(LandmarkId landmark, const PastPose& past) const;
  /// Enters a landmark whose place is known relative to a past pose: it gets that pose's error and correlations, and
  /// `covariance`, as of covariance_given(), on top.
  void add_point(LandmarkId landmark, const Eigen::Vector3d& position, const PastPose& past,
                 const Eigen::Matrix3d& covariance);
  /// Makes the landmarks Cartesian that have become linear; `camera` has just seen them. Those whose inverse depth is
  /// not positive are returned: they are no points of this world.
  std::vector<LandmarkId> convert(const Camera& camera, std::span<const LandmarkId> landmarks);
  void remove(std::span<const LandmarkId> landmarks);

  /// Keeps the current pose for the final trajectory. Over `max_keyframes` the one that is missed least goes.
  void add_keyframe(common::Nanoseconds stamp, int max_keyframes);
  /// How far a pose is from the estimate, in squared standard deviations of both together (three degrees of freedom).
  double distance_to(const common::Pose2& measured, const Eigen::Matrix3d& covariance) const;
  /// Corrects everything by a measured pose. When it contradicts the estimate, which then was more certain of itself
  /// than it should have been, all covariances are first enlarged by the factor that makes it plausible; without that
  /// the correction would stop half-way.
  void correct_pose(const common::Pose2& measured, const Eigen::Matrix3d& covariance);
  /// The scale of what these landmarks and the speed say grows uncertain by `sigma`, a share of it: their places about
  /// the robot and the speed get an error in common. Bearings
  /// see it only as far as the camera is off base_link and off where inverse depths are anchored.
  void let_scale_drift(std::span<const LandmarkId> landmarks, double sigma);
  /// The speed alone grows uncertain by `sigma`, of its unit.
  void doubt_speed(double sigma);
  /// Whether enough is known of a landmark's depth for it to teach the robot its speed (see the README, depth).
  bool knows_depth(LandmarkId landmark) const;
  /// Corrects everything by a measured speed forward [m/s] of the step predicted last, for motion models that have one.
  /// Returns whether it was believed: not when it is more than three standard deviations off.
  bool correct_speed(double measured, double sigma);
  /// Replaces the robot's pose in the plane; it knows nothing of the landmarks any more, and landmarks without depth
  /// go.
  std::vector<LandmarkId> set_pose(const common::Pose2& pose, const Eigen::Matrix3d& covariance);

  /// Place of a landmark with known depth (Cartesian).
  std::optional<MapPoint> map_point(LandmarkId landmark) const;
  /// Where a landmark most likely is [m], however well its depth is known; empty while its inverse depth is not
  /// positive.
  std::optional<Eigen::Vector3d> likely_position(LandmarkId landmark) const;

 private:
  SlipWatch::Verdict watch_wheels(std::span<const LinearMeasurement> measurements, const Eigen::MatrixXd& covariance);
  MeasurementModel model() const {
    return {state_, robot_, motion_parameters_, *motion_, options_.inverse_depth_sigma};
  }
  std::optional<LinearMeasurement> linearise(const Camera& camera, const Measurement& measurement) const;
  void correct(const Camera& camera, std::span<const Measurement> measurements, UpdateReport& report);
  /// The bearing as noisy as the motion model wants it taken.
  Bearing with_margin(Bearing bearing) const;
  bool starts_delayed() const;
  bool pair_up(const Camera& camera, const Measurement& measurement);
  std::vector<bool> which_depths_count(std::span<const Measurement> measurements,
                                       std::span<const std::size_t> accepted) const;
  bool depth_is_known(const FilterLandmark& landmark) const;
  void ignore_parallax(LinearMeasurement& linear) const;
  void learn_depth(const Camera& camera, const Measurement& measurement);
  /// The inverse depths of the accepted landmarks whose depth is known.
  std::vector<double> known_inverse_depths(const Camera& camera, std::span<const Measurement> measurements,
                                           std::span<const std::size_t> accepted) const;
  DepthGuess guessed_depth() const;
  void remove_blocks(std::vector<BlockId> blocks);

  FilterOptions options_;
  std::shared_ptr<const MotionModel> motion_;
  State state_;
  BlockId robot_;
  BlockId motion_parameters_;
  std::map<LandmarkId, FilterLandmark> landmarks_;
  PastPoses past_poses_;
  bool metres_are_told_ = false;
  std::optional<double> typical_inverse_depth_;  // of what the last image saw; empty when too little is known
  SlipWatch wheels_;
  SlipAdmission slip_admission_;
};

}  // namespace slamfuse::visual_slam
