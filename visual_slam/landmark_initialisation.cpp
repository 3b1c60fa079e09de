// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_initialisation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "visual_slam/consensus.hpp"
#include "visual_slam/observation_pair.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kImpossible = 3.0;  // standard deviations an inverse depth may be below 0: cutting at 0 would keep
                                     // only the landmarks that seem too near and so shrink the map

double square(double value) { return value * value; }

}  // namespace

BlockId enter_by_inverse_depth(State& state, const Bearing& bearing, const DepthGuess& depth) {
  const Eigen::Vector3d numbers(bearing.point.x(), bearing.point.y(), depth.inverse_depth);
  const Eigen::Matrix3d noise =
      Eigen::Vector3d(square(bearing.sigma), square(bearing.sigma), square(depth.sigma)).asDiagonal();
  return state.append(numbers, BlockKind::kInverseDepth, {}, noise);
}

PairOutcome pair_up(State& state, const MeasurementModel& model, FilterLandmark& landmark, const Camera& camera,
                    const Bearing& bearing, const FilterOptions& options) {
  const RelativeMotion relative = relative_motion(state, landmark.anchor_pose, model.robot());
  const ObservationPair pair{.first_camera = landmark.anchor.camera,
                             .second_camera = &camera,
                             .first = landmark.first,
                             .second = bearing,
                             .motion = relative.motion,
                             .motion_covariance = relative.covariance,
                             .lever_scale = model.lever_scale()};
  const std::optional<Prediction> prediction = model.predict(camera, landmark, bearing.row_shift);
  const std::optional<Intersection> at = intersect(pair);
  if (!prediction) return PairOutcome::kMisfit;
  if (!at) return PairOutcome::kFits;
  const Eigen::Vector2d across(-at->along.y(), at->along.x());
  const double miss = across.dot(bearing.point - prediction->point);
  const double variance = across.dot(prediction->covariance * across) + square(bearing.sigma);
  if (square(miss) > chi_square_gate_2(options.gate_probability) * variance) return PairOutcome::kMisfit;
  if (at->inverse_depth > 0.0) landmark.inverse_depth = at->inverse_depth;
  if (divergence_from_gaussian(pair, *at, options.divergence_samples) > options.max_divergence) {
    return PairOutcome::kFits;
  }
  const std::optional<PairPoint> point = point_of_pair(pair, *at, body_pose(state, landmark.anchor_pose));
  if (!point) return PairOutcome::kFits;
  std::vector<JacobianPart<Eigen::Dynamic>> parts;
  for (const JacobianPart<3>& part :
       {pose_part(state, model.robot(), point->wrt_robot), pose_part(state, landmark.anchor_pose, point->wrt_anchor)}) {
    parts.push_back({part.block, part.matrix});
  }
  if (const auto lever = model.lever_part<3>(point->wrt_lever_scale)) parts.push_back({lever->block, lever->matrix});
  landmark.block = state.append(point->position, BlockKind::kPoint, parts, point->covariance);
  landmark.form = LandmarkForm::kPoint;
  return PairOutcome::kEntered;
}

Conversion make_cartesian(State& state, const MeasurementModel& model, FilterLandmark& landmark, const Camera& camera,
                          double largest_index) {
  const Eigen::Vector3d numbers = state.mean(landmark.block);
  const double sigma = std::sqrt(std::max(0.0, state.covariance(landmark.block, landmark.block)(2, 2)));
  if (numbers.z() < -kImpossible * sigma) return Conversion::kImpossible;
  if (numbers.z() <= 0.0) return Conversion::kNotYet;
  const BodyPose anchor_pose = body_pose(state, landmark.anchor_pose);
  const CartesianPoint point = to_cartesian(landmark.anchor, anchor_pose, numbers, model.lever_scale());
  const double index = linearity_index(optical_centre(*landmark.anchor.camera, anchor_pose, model.lever_scale()),
                                       optical_centre(camera, body_pose(state, model.robot()), model.lever_scale()),
                                       point.position, numbers.z(), sigma);
  if (index > largest_index) return Conversion::kNotYet;
  const JacobianPart<3> by_anchor = pose_part(state, landmark.anchor_pose, point.wrt_anchor);
  std::vector<JacobianPart<Eigen::Dynamic>> parts = {{by_anchor.block, by_anchor.matrix},
                                                     {landmark.block, point.wrt_landmark}};
  if (const auto lever = model.lever_part<3>(point.wrt_lever_scale)) parts.push_back({lever->block, lever->matrix});
  state.transform(landmark.block, point.position, BlockKind::kPoint, parts, Eigen::Matrix3d::Zero());
  landmark.form = LandmarkForm::kPoint;
  return Conversion::kDone;
}

}  // namespace slamfuse::visual_slam
