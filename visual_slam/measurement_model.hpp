// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "visual_slam/camera.hpp"
#include "visual_slam/motion_model.hpp"
#include "visual_slam/pose_block.hpp"
#include "visual_slam/projection.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// Where a landmark should appear.
struct Prediction {
  Eigen::Vector2d point;       ///< normalised image point (x/z, y/z)
  Eigen::Matrix2d covariance;  ///< of `point`, without the measurement noise
};

/// A landmark's place in the map.
struct MapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< [m^2]
};

/// What is known of a landmark's place: one ray and a guess, outside the state; by inverse depth; a point; or a point
/// of a saved map, outside the state.
enum class LandmarkForm { kWaiting, kInverseDepth, kPoint, kFixed };

/// A landmark of the filter.
struct FilterLandmark {
  LandmarkForm form = LandmarkForm::kInverseDepth;
  BlockId block = 0;        ///< where in_state()
  BlockId anchor_pose = 0;  ///< block of the past pose, where anchored()
  Anchor anchor = {};
  Bearing first = {};          ///< while it waits
  double inverse_depth = 0.0;  ///< [1/m] while it waits: where to look for it
  MapPoint fixed = {};         ///< of a saved map

  bool anchored() const { return form == LandmarkForm::kWaiting || form == LandmarkForm::kInverseDepth; }
  bool in_state() const { return form == LandmarkForm::kInverseDepth || form == LandmarkForm::kPoint; }
  /// Of the state, of a saved map, or, while it waits, (u, v, rho) of its first sight.
  Eigen::Vector3d numbers(const State& state) const;
};

/// How landmarks appear to a camera on the robot as the state has it now (seed 000 eq. 1), linearised there. A view on
/// the state, to be made where it is needed.
class MeasurementModel {
 public:
  /// `robot` and `parameters` are the blocks of the pose and of the motion model's numbers; `inverse_depth_sigma`
  /// [1/m] is how little is known of the depth of a landmark that waits.
  MeasurementModel(const State& state, BlockId robot, BlockId parameters, const MotionModel& motion,
                   double inverse_depth_sigma)
      : state_(state),
        robot_(robot),
        parameters_(parameters),
        motion_(motion),
        inverse_depth_sigma_(inverse_depth_sigma) {}

  BlockId robot() const { return robot_; }
  /// How many units of the map a metre is.
  double lever_scale() const { return motion_.lever_scale(state_, parameters_); }
  /// Where a landmark should appear; empty when it is behind the camera. `row_shift` as in Bearing.
  std::optional<Prediction> predict(const Camera& camera, const FilterLandmark& landmark,
                                    const BodyPose& row_shift) const;
  /// The bearing of a landmark as a measurement of the state. The last part of its Jacobian is that of the landmark,
  /// unless it is fixed; then its uncertainty is in the noise.
  std::optional<LinearMeasurement> linearise(const Camera& camera, const FilterLandmark& landmark,
                                             const Bearing& bearing) const;
  /// The part of a derivative by the logarithm of the lever scale, where that is a number of the state.
  template <int Rows>
  std::optional<JacobianPart<Rows>> lever_part(const Eigen::Matrix<double, Rows, 1>& wrt_lever_scale) const {
    const std::optional<int> index = motion_.lever_scale_index();
    if (!index) return std::nullopt;
    JacobianPart<Rows> part{parameters_, Eigen::MatrixXd::Zero(Rows, state_.mean(parameters_).size())};
    part.matrix.col(*index) = wrt_lever_scale;
    return part;
  }

 private:
  std::optional<Projection> project(const Camera& camera, const FilterLandmark& landmark,
                                    const BodyPose& row_shift) const;

  const State& state_;
  BlockId robot_;
  BlockId parameters_;
  const MotionModel& motion_;
  double inverse_depth_sigma_;
};

}  // namespace slamfuse::visual_slam
