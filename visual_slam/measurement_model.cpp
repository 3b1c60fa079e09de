// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/measurement_model.hpp"

#include <utility>
#include <vector>

namespace slamfuse::visual_slam {
namespace {

double square(double value) { return value * value; }

}  // namespace

Eigen::Vector3d FilterLandmark::numbers(const State& state) const {
  if (in_state()) return state.mean(block);
  if (form == LandmarkForm::kFixed) return fixed.position;
  return {first.point.x(), first.point.y(), inverse_depth};
}

std::optional<Projection> MeasurementModel::project(const Camera& camera, const FilterLandmark& landmark,
                                                    const BodyPose& row_shift) const {
  const Eigen::Vector3d numbers = landmark.numbers(state_);
  const BodyPose robot = body_pose(state_, robot_);
  if (!landmark.anchored()) return project_cartesian(camera, row_shift, robot, numbers, lever_scale());
  return project_anchored(camera, row_shift, robot, landmark.anchor, body_pose(state_, landmark.anchor_pose), numbers,
                          lever_scale());
}

std::optional<LinearMeasurement> MeasurementModel::linearise(const Camera& camera, const FilterLandmark& landmark,
                                                             const Bearing& bearing) const {
  const std::optional<Projection> projection = project(camera, landmark, bearing.row_shift);
  if (!projection) return std::nullopt;
  LinearMeasurement linear;
  linear.residual = bearing.point - projection->point;
  linear.noise = square(bearing.sigma) * Eigen::Matrix2d::Identity();
  linear.jacobian.push_back(pose_part(state_, robot_, projection->wrt_robot));
  if (landmark.anchored()) linear.jacobian.push_back(pose_part(state_, landmark.anchor_pose, projection->wrt_anchor));
  if (std::optional<JacobianPart<2>> lever = lever_part<2>(projection->wrt_lever_scale)) {
    linear.jacobian.push_back(std::move(*lever));
  }
  if (landmark.form == LandmarkForm::kFixed) {
    linear.noise += projection->wrt_landmark * landmark.fixed.covariance * projection->wrt_landmark.transpose();
  } else {
    linear.jacobian.push_back({landmark.block, projection->wrt_landmark});
  }
  return linear;
}

std::optional<Prediction> MeasurementModel::predict(const Camera& camera, const FilterLandmark& landmark,
                                                    const BodyPose& row_shift) const {
  const std::optional<Projection> projection = project(camera, landmark, row_shift);
  if (!projection) return std::nullopt;
  std::vector<JacobianPart<2>> parts = {pose_part(state_, robot_, projection->wrt_robot)};
  if (landmark.in_state()) parts.push_back({landmark.block, projection->wrt_landmark});
  if (landmark.anchored()) parts.push_back(pose_part(state_, landmark.anchor_pose, projection->wrt_anchor));
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  if (landmark.form == LandmarkForm::kFixed) {
    covariance = projection->wrt_landmark * landmark.fixed.covariance * projection->wrt_landmark.transpose();
  }
  for (const auto& [row, by_row] : parts) {
    for (const auto& [column, by_column] : parts) {
      covariance += by_row * state_.covariance(row, column) * by_column.transpose();
    }
  }
  if (const std::optional<JacobianPart<2>> lever = lever_part<2>(projection->wrt_lever_scale)) {
    Eigen::Matrix2d cross = Eigen::Matrix2d::Zero();
    for (const auto& [row, by_row] : parts) {
      cross += by_row * state_.covariance(row, lever->block) * lever->matrix.transpose();
    }
    covariance += cross + cross.transpose() +
                  lever->matrix * state_.covariance(lever->block, lever->block) * lever->matrix.transpose();
  }
  if (landmark.form == LandmarkForm::kWaiting) {
    const Eigen::Vector3d variances(square(landmark.first.sigma), square(landmark.first.sigma),
                                    square(inverse_depth_sigma_));
    covariance += projection->wrt_landmark * variances.asDiagonal() * projection->wrt_landmark.transpose();
  }
  return Prediction{projection->point, covariance};
}

}  // namespace slamfuse::visual_slam
