// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/ekf.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "common/angle.hpp"
#include "visual_slam/consensus.hpp"
#include "visual_slam/observation_pair.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kImpossible = 3.0;      // standard deviations an inverse depth may be below 0: cutting at 0 would keep
                                         // only the landmarks that seem too near and so shrink the map
constexpr double kPlausible = 7.8;       // squared standard deviations of three numbers that 95 % stay below
constexpr double kInflationStep = 1.25;  // factors of the covariance that are tried
constexpr double kMostInflation = 1e6;
constexpr double kImprobable = 16.3;  // chi-square of the odometry's three systematic errors, 0.999
constexpr double kBlindness = 100.0;  // times the noise of a bearing, along a parallax that must not count

double square(double value) { return value * value; }

Eigen::Vector3d pose_residual(const common::Pose2& from, const common::Pose2& to) {
  return {to.x - from.x, to.y - from.y, common::normalize_angle(to.theta - from.theta)};
}

/// How a point that hangs on a pose moves with the pose's six numbers, see BodyPose.
Eigen::Matrix<double, 3, 6> point_by_pose(const Eigen::Vector3d& point, const BodyPose& pose) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << Eigen::Matrix3d::Identity(), -cross_matrix(point - pose.position);
  return jacobian;
}

/// S = H P H^T + R from P H^T.
Eigen::MatrixXd innovation_covariance(const State& state, std::span<const LinearMeasurement> measurements,
                                      const Eigen::MatrixXd& covariance_times_jacobian) {
  Eigen::MatrixXd s = state.jacobian_times(measurements, covariance_times_jacobian);
  for (int i = 0; i < static_cast<int>(measurements.size()); ++i) {
    s.block<2, 2>(2 * i, 2 * i) += measurements[static_cast<std::size_t>(i)].noise;
  }
  return s;
}

Eigen::VectorXd stacked_residuals(std::span<const LinearMeasurement> measurements) {
  Eigen::VectorXd residuals(2 * static_cast<int>(measurements.size()));
  for (int i = 0; i < static_cast<int>(measurements.size()); ++i) {
    residuals.segment<2>(2 * i) = measurements[static_cast<std::size_t>(i)].residual;
  }
  return residuals;
}

}  // namespace

Ekf::Ekf(const FilterOptions& filter, const MotionOptions& motion)
    : options_(filter), motion_(make_motion_model(motion)) {
  robot_ = motion_->append_robot(state_);
  motion_parameters_ = motion_->append_parameters(state_);
}

const PastPose* Ekf::keyframe_at(common::Nanoseconds stamp) const {
  const auto found = std::find_if(past_poses_.begin(), past_poses_.end(),
                                  [stamp](const PastPose& past) { return past.keyframe && past.stamp == stamp; });
  return found == past_poses_.end() ? nullptr : &*found;
}

void Ekf::predict(const MotionStep& step) {
  const common::Pose2 before = pose();
  const std::optional<Slip> slip = motion_->slip(state_, robot_, motion_parameters_, step);
  if (motion_->predict(state_, robot_, motion_parameters_, step)) moved_ = true;
  if (!slip) return;
  wheels_.move(*slip, pose().translation() - before.translation(), step.seconds);
}

bool Ekf::odometry_is_doubtful() const {
  return wheels_.doubtful() || motion_->improbability(state_, motion_parameters_) > kImprobable;
}

SlipWatch::Verdict Ekf::watch_wheels(std::span<const LinearMeasurement> measurements,
                                     const Eigen::MatrixXd& covariance) {
  if (!wheels_.since_image()) return SlipWatch::Verdict::kNothing;
  Eigen::Matrix<double, Eigen::Dynamic, 2> by_slip(covariance.rows(), 2);
  for (int i = 0; i < static_cast<int>(measurements.size()); ++i) {
    by_slip.middleRows<2>(2 * i) =
        measurements[static_cast<std::size_t>(i)].jacobian.front().matrix * wheels_.since_image()->pose;
  }
  if (by_slip.cwiseAbs().maxCoeff() < std::sqrt(measurements.front().noise(0, 0))) return SlipWatch::Verdict::kNothing;
  const SlipWatch::Verdict verdict = wheels_.judge(slip_evidence(stacked_residuals(measurements), covariance, by_slip,
                                                                 chi_square_gate_2(options_.gate_probability)));
  if (verdict == SlipWatch::Verdict::kSlip) admit_slip();
  if (verdict == SlipWatch::Verdict::kGrip) admit_grip();
  return verdict;
}

/// Makes the odometry's scale as uncertain as slip makes it, and with it the pose reached by it since the last image.
/// The camera then tells by how much the wheels slip, and the odometry corrected by that keeps the map's scale.
void Ekf::admit_slip() {
  grip_mean_ = state_.mean(motion_parameters_);
  grip_covariance_ = state_.covariance(motion_parameters_, motion_parameters_);
  const Slip& by_slip = *wheels_.since_image();
  const BlockId slip = state_.append(Eigen::Vector2d::Zero(), BlockKind::kCalibration, {}, Eigen::Matrix2d::Identity());
  const int parameters = static_cast<int>(grip_mean_.size());
  const JacobianPart<Eigen::Dynamic> to_parameters[] = {
      {motion_parameters_, Eigen::MatrixXd::Identity(parameters, parameters)}, {slip, by_slip.parameters}};
  state_.transform(motion_parameters_, grip_mean_, BlockKind::kCalibration, to_parameters,
                   Eigen::MatrixXd::Zero(parameters, parameters));
  const JacobianPart<Eigen::Dynamic> to_pose[] = {{robot_, Eigen::Matrix3d::Identity()}, {slip, by_slip.pose}};
  state_.transform(robot_, Eigen::VectorXd(state_.mean(robot_)), BlockKind::kPose, to_pose, Eigen::Matrix3d::Zero());
  state_.remove(std::span(&slip, 1));
}

/// Gives the odometry the systematic errors it had before the wheels slipped, also for the way since the last image.
void Ekf::admit_grip() {
  const Slip& by_slip = *wheels_.since_image();
  const Eigen::MatrixXd to_pose = by_slip.pose * by_slip.parameters.colPivHouseholderQr().solve(
                                                     Eigen::MatrixXd::Identity(grip_mean_.size(), grip_mean_.size()));
  const Eigen::Vector3d change = to_pose * (grip_mean_ - state_.mean(motion_parameters_));
  const Eigen::Matrix3d noise =
      to_pose * state_.covariance(motion_parameters_, motion_parameters_) * to_pose.transpose();
  const JacobianPart<Eigen::Dynamic> same[] = {{robot_, Eigen::Matrix3d::Identity()}};
  state_.transform(robot_, Eigen::VectorXd(state_.mean(robot_) + change), BlockKind::kPose, same, noise);
  state_.transform(motion_parameters_, grip_mean_, BlockKind::kCalibration, {}, grip_covariance_);
}

std::optional<Projection> Ekf::project(const Camera& camera, const FilterLandmark& landmark,
                                       const BodyPose& row_shift) const {
  const Eigen::Vector3d numbers = numbers_of(landmark);
  const BodyPose robot = body_pose(state_, robot_);
  if (!landmark.anchored()) return project_cartesian(camera, row_shift, robot, numbers, lever_scale());
  return project_anchored(camera, row_shift, robot, landmark.anchor, body_pose(state_, landmark.anchor_pose), numbers,
                          lever_scale());
}

Eigen::Vector3d Ekf::numbers_of(const FilterLandmark& landmark) const {
  if (landmark.in_state()) return state_.mean(landmark.block);
  if (landmark.form == LandmarkForm::kFixed) return landmark.fixed.position;
  return {landmark.first.point.x(), landmark.first.point.y(), landmark.inverse_depth};
}

std::optional<LinearMeasurement> Ekf::linearise(const Camera& camera, const Measurement& measurement) const {
  const FilterLandmark& landmark = landmarks_.at(measurement.landmark);
  const std::optional<Projection> projection = project(camera, landmark, measurement.bearing.row_shift);
  if (!projection) return std::nullopt;
  LinearMeasurement linear;
  linear.residual = measurement.bearing.point - projection->point;
  linear.noise = square(measurement.bearing.sigma) * Eigen::Matrix2d::Identity();
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

template <int Rows>
std::optional<JacobianPart<Rows>> Ekf::lever_part(const Eigen::Matrix<double, Rows, 1>& wrt_lever_scale) const {
  const std::optional<int> index = motion_->lever_scale_index();
  if (!index) return std::nullopt;
  JacobianPart<Rows> part{motion_parameters_, Eigen::MatrixXd::Zero(Rows, state_.mean(motion_parameters_).size())};
  part.matrix.col(*index) = wrt_lever_scale;
  return part;
}

std::optional<Prediction> Ekf::predict_bearing(const Camera& camera, LandmarkId landmark,
                                               const BodyPose& row_shift) const {
  return predict(camera, landmarks_.at(landmark), row_shift);
}

std::optional<Prediction> Ekf::predict_point(const Camera& camera, const MapPoint& point,
                                             const BodyPose& row_shift) const {
  return predict(camera, {.form = LandmarkForm::kFixed, .fixed = point}, row_shift);
}

std::optional<Prediction> Ekf::predict(const Camera& camera, const FilterLandmark& entry,
                                       const BodyPose& row_shift) const {
  const std::optional<Projection> projection = project(camera, entry, row_shift);
  if (!projection) return std::nullopt;
  std::vector<JacobianPart<2>> parts = {pose_part(state_, robot_, projection->wrt_robot)};
  if (entry.in_state()) parts.push_back({entry.block, projection->wrt_landmark});
  if (entry.anchored()) parts.push_back(pose_part(state_, entry.anchor_pose, projection->wrt_anchor));
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  if (entry.form == LandmarkForm::kFixed) {
    covariance = projection->wrt_landmark * entry.fixed.covariance * projection->wrt_landmark.transpose();
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
  if (entry.form == LandmarkForm::kWaiting) {
    const Eigen::Vector3d variances(square(entry.first.sigma), square(entry.first.sigma),
                                    square(options_.inverse_depth_sigma));
    covariance += projection->wrt_landmark * variances.asDiagonal() * projection->wrt_landmark.transpose();
  }
  return Prediction{projection->point, covariance};
}

bool Ekf::depth_is_known(const FilterLandmark& landmark) const {
  if (!landmark.anchored()) return true;
  const double rho = state_.mean(landmark.block)[2];
  return std::sqrt(state_.covariance(landmark.block, landmark.block)(2, 2)) < options_.known_depth * rho;
}

/// For each measurement, whether its parallax may teach the robot. Without metres from the motion model somebody has to
/// say how fast the robot moves, and while few depths are known that is the inverse depth landmarks start with.
std::vector<bool> Ekf::which_depths_count(std::span<const Measurement> measurements,
                                          std::span<const std::size_t> accepted) const {
  std::vector<bool> count(measurements.size());
  int known = 0;
  for (const std::size_t i : accepted) {
    count[i] = depth_is_known(landmarks_.at(measurements[i].landmark));
    known += count[i] ? 1 : 0;
  }
  if (!motion_->is_metric() && known < options_.min_known_depths) count.assign(count.size(), true);
  return count;
}

/// Makes the measurement blind along the direction in which the landmark moves with its inverse depth.
void Ekf::ignore_parallax(LinearMeasurement& linear) const {
  const Eigen::Vector2d by_depth = linear.jacobian.back().matrix.col(2);
  if (by_depth.norm() * options_.inverse_depth_sigma < std::sqrt(linear.noise(0, 0))) return;
  const Eigen::Vector2d along = by_depth.normalized();
  linear.noise += square(kBlindness) * linear.noise(0, 0) * along * along.transpose();
}

void Ekf::learn_depth(const Camera& camera, const Measurement& measurement) {
  const std::optional<LinearMeasurement> linear = linearise(camera, measurement);
  if (!linear) return;
  const Eigen::Vector2d by_depth = linear->jacobian.back().matrix.col(2);
  if (by_depth.norm() * options_.inverse_depth_sigma < measurement.bearing.sigma) return;
  const Eigen::Vector2d along = by_depth.normalized();
  std::vector<JacobianPart<1>> jacobian;
  for (const auto& part : linear->jacobian) jacobian.push_back({part.block, along.transpose() * part.matrix});
  state_.correct_alone(landmarks_.at(measurement.landmark).block, along.dot(linear->residual), jacobian,
                       square(measurement.bearing.sigma));
}

UpdateReport Ekf::update(const Camera& camera, std::span<const Measurement> measurements) {
  UpdateReport report;
  report.accepted.assign(measurements.size(), false);
  typical_inverse_depth_.reset();
  correct(camera, measurements, report);
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    if (landmarks_.at(measurements[i].landmark).form != LandmarkForm::kWaiting) continue;
    report.accepted[i] = pair_up(camera, measurements[i]);
  }
  report.inliers = static_cast<int>(std::count(report.accepted.begin(), report.accepted.end(), true));
  return report;
}

void Ekf::correct(const Camera& camera, std::span<const Measurement> measurements, UpdateReport& report) {
  std::vector<std::size_t> used;
  std::vector<LinearMeasurement> linear;
  for (std::size_t i = 0; i < measurements.size(); ++i) {
    if (landmarks_.at(measurements[i].landmark).form == LandmarkForm::kWaiting) continue;
    if (std::optional<LinearMeasurement> one = linearise(camera, measurements[i])) {
      used.push_back(i);
      linear.push_back(std::move(*one));
    }
  }
  if (linear.empty()) return;
  Eigen::MatrixXd covariance = innovation_covariance(state_, linear, state_.covariance_times_jacobian(linear));
  report.wheels = watch_wheels(linear, covariance);
  if (report.wheels != SlipWatch::Verdict::kNothing) {
    covariance = innovation_covariance(state_, linear, state_.covariance_times_jacobian(linear));
  }
  wheels_.next_image();
  const Consensus consensus =
      find_consensus(stacked_residuals(linear), covariance, chi_square_gate_2(options_.gate_probability));
  report.mean_nis = consensus.mean_nis;
  std::vector<std::size_t> accepted;
  for (const int i : consensus.accepted) accepted.push_back(used[static_cast<std::size_t>(i)]);

  if (options_.scene_depth_sigma > 0.0 && motion_->is_metric()) {
    typical_inverse_depth_ = typical_inverse_depth(camera, measurements, accepted);
  }
  const std::vector<bool> depth_known = which_depths_count(measurements, accepted);
  const Eigen::VectorXd prior = state_.mean();
  for (int iteration = 0; iteration < options_.iterations && !accepted.empty(); ++iteration) {
    linear.clear();
    std::erase_if(accepted, [&](std::size_t i) {
      std::optional<LinearMeasurement> one = linearise(camera, measurements[i]);
      if (!one) return true;
      if (!depth_known[i]) ignore_parallax(*one);
      linear.push_back(std::move(*one));
      return false;
    });
    const Eigen::MatrixXd gain_side = state_.covariance_times_jacobian(linear);
    const Eigen::LLT<Eigen::MatrixXd> llt(innovation_covariance(state_, linear, gain_side));
    const Eigen::VectorXd back_to_prior = state_.error_given(prior);
    const Eigen::VectorXd residual = stacked_residuals(linear) - state_.jacobian_times(linear, back_to_prior);
    const Eigen::VectorXd step = back_to_prior + gain_side * llt.solve(residual);
    if (iteration + 1 == options_.iterations) {
      state_.subtract_outer_product(llt.matrixL().solve(gain_side.transpose()).transpose());
    }
    state_.correct(step);
  }
  for (const std::size_t i : accepted) {
    if (!depth_known[i]) learn_depth(camera, measurements[i]);
    report.accepted[i] = true;
  }
}

bool Ekf::starts_delayed() const {
  if (options_.initialisation == InitialisationKind::kInverseDepth) return false;
  if (motion_->is_metric()) return true;
  // Nobody but the landmarks knows how fast the robot moves, and a pair of sights says nothing without that.
  const auto known = std::count_if(landmarks_.begin(), landmarks_.end(),
                                   [](const auto& entry) { return entry.second.form == LandmarkForm::kPoint; });
  return known >= options_.min_known_depths;
}

/// Whether a bearing of a waiting landmark fits its epipolar line; makes the landmark a point when the pair with its
/// first sight is well-conditioned.
bool Ekf::pair_up(const Camera& camera, const Measurement& measurement) {
  FilterLandmark& landmark = landmarks_.at(measurement.landmark);
  const RelativeMotion relative = relative_motion(state_, landmark.anchor_pose, robot_);
  const ObservationPair pair{.first_camera = landmark.anchor.camera,
                             .second_camera = &camera,
                             .first = landmark.first,
                             .second = measurement.bearing,
                             .motion = relative.motion,
                             .motion_covariance = relative.covariance,
                             .lever_scale = lever_scale()};
  const std::optional<Prediction> prediction =
      predict_bearing(camera, measurement.landmark, measurement.bearing.row_shift);
  const std::optional<Intersection> at = intersect(pair);
  if (!prediction || !at) return prediction.has_value();
  const Eigen::Vector2d across(-at->along.y(), at->along.x());
  const double miss = across.dot(measurement.bearing.point - prediction->point);
  const double variance = across.dot(prediction->covariance * across) + square(measurement.bearing.sigma);
  if (square(miss) > chi_square_gate_2(options_.gate_probability) * variance) return false;
  if (at->inverse_depth > 0.0) landmark.inverse_depth = at->inverse_depth;
  if (divergence_from_gaussian(pair, *at, options_.divergence_samples) > options_.max_divergence) return true;
  const std::optional<PairPoint> point = point_of_pair(pair, *at, body_pose(state_, landmark.anchor_pose));
  if (!point) return true;
  std::vector<JacobianPart<Eigen::Dynamic>> parts;
  for (const JacobianPart<3>& part :
       {pose_part(state_, robot_, point->wrt_robot), pose_part(state_, landmark.anchor_pose, point->wrt_anchor)}) {
    parts.push_back({part.block, part.matrix});
  }
  if (const auto lever = lever_part<3>(point->wrt_lever_scale)) parts.push_back({lever->block, lever->matrix});
  landmark.block = state_.append(point->position, BlockKind::kPoint, parts, point->covariance);
  landmark.form = LandmarkForm::kPoint;
  --past_pose_of(landmark.anchor_pose).anchored;
  return true;
}

PastPose& Ekf::past_pose_now(common::Nanoseconds stamp) {
  if (past_poses_.empty() || moved_ || past_poses_.back().stamp != stamp) {
    const BlockId block = append_copy(state_, robot_);
    past_poses_.push_back({.block = block, .stamp = stamp, .keyframe = false, .anchored = 0});
    moved_ = false;
  }
  return past_poses_.back();
}

PastPose& Ekf::past_pose_of(BlockId block) {
  return *std::find_if(past_poses_.begin(), past_poses_.end(),
                       [block](const PastPose& past) { return past.block == block; });
}

void Ekf::add_landmark(LandmarkId landmark, const Camera& camera, const Bearing& bearing, common::Nanoseconds stamp) {
  PastPose& anchor = past_pose_now(stamp);
  ++anchor.anchored;
  FilterLandmark entry{.form = LandmarkForm::kWaiting,
                       .block = 0,
                       .anchor_pose = anchor.block,
                       .anchor = {&camera, bearing.row_shift},
                       .first = bearing,
                       .inverse_depth = options_.initial_inverse_depth};
  if (!starts_delayed()) {
    entry.form = LandmarkForm::kInverseDepth;
    entry.block = append_inverse_depth(bearing);
  }
  landmarks_.emplace(landmark, std::move(entry));
}

/// The median inverse depth of the accepted landmarks whose depth is known: what a new one in this image has, probably.
std::optional<double> Ekf::typical_inverse_depth(const Camera& camera, std::span<const Measurement> measurements,
                                                 std::span<const std::size_t> accepted) const {
  const BodyPose robot = body_pose(state_, robot_);
  const Eigen::Vector3d axis = robot.rotation * camera.R_base_camera.col(2);
  std::vector<double> inverse_depths;
  for (const std::size_t i : accepted) {
    const LandmarkId id = measurements[i].landmark;
    if (!depth_is_known(landmarks_.at(id))) continue;
    const std::optional<Eigen::Vector3d> at = likely_position(id);
    if (!at) continue;
    const double depth = axis.dot(*at - camera_centre(camera));
    if (depth > 0.0) inverse_depths.push_back(1.0 / depth);
  }
  if (static_cast<int>(inverse_depths.size()) < options_.min_known_depths) return std::nullopt;
  const auto middle = inverse_depths.begin() + static_cast<std::ptrdiff_t>(inverse_depths.size() / 2);
  std::nth_element(inverse_depths.begin(), middle, inverse_depths.end());
  return *middle;
}

BlockId Ekf::append_inverse_depth(const Bearing& bearing) {
  double inverse_depth = options_.initial_inverse_depth;
  double sigma = options_.inverse_depth_sigma;
  if (typical_inverse_depth_) {
    inverse_depth = *typical_inverse_depth_;
    sigma = options_.scene_depth_sigma * inverse_depth;
  }
  const Eigen::Vector3d numbers(bearing.point.x(), bearing.point.y(), inverse_depth);
  const Eigen::Matrix3d noise =
      Eigen::Vector3d(square(bearing.sigma), square(bearing.sigma), square(sigma)).asDiagonal();
  return state_.append(numbers, BlockKind::kInverseDepth, {}, noise);
}

void Ekf::add_fixed_landmark(LandmarkId landmark, const MapPoint& point) {
  landmarks_.emplace(landmark, FilterLandmark{.form = LandmarkForm::kFixed, .fixed = point});
}

Eigen::Matrix3d Ekf::covariance_given(LandmarkId landmark, const PastPose& past) const {
  const FilterLandmark& entry = landmarks_.at(landmark);
  const Eigen::MatrixXd by_pose =
      pose_part(state_, past.block, point_by_pose(state_.mean(entry.block), body_pose(state_, past.block))).matrix;
  const Eigen::Matrix3d cross = by_pose * state_.covariance(past.block, entry.block);
  return state_.covariance(entry.block, entry.block) - cross - cross.transpose() +
         by_pose * state_.covariance(past.block, past.block) * by_pose.transpose();
}

void Ekf::add_point(LandmarkId landmark, const Eigen::Vector3d& position, const PastPose& past,
                    const Eigen::Matrix3d& covariance) {
  const JacobianPart<Eigen::Dynamic> part[] = {
      {past.block, pose_part(state_, past.block, point_by_pose(position, body_pose(state_, past.block))).matrix}};
  const BlockId block = state_.append(position, BlockKind::kPoint, part, covariance);
  landmarks_.emplace(landmark, FilterLandmark{.form = LandmarkForm::kPoint, .block = block});
}

std::vector<LandmarkId> Ekf::convert(const Camera& camera, std::span<const LandmarkId> landmarks) {
  std::vector<LandmarkId> impossible;
  for (const LandmarkId id : landmarks) {
    FilterLandmark& landmark = landmarks_.at(id);
    if (landmark.form != LandmarkForm::kInverseDepth) continue;
    const Eigen::Vector3d numbers = state_.mean(landmark.block);
    const double sigma = std::sqrt(std::max(0.0, state_.covariance(landmark.block, landmark.block)(2, 2)));
    if (numbers.z() < -kImpossible * sigma) impossible.push_back(id);
    if (numbers.z() <= 0.0) continue;
    const BodyPose anchor_pose = body_pose(state_, landmark.anchor_pose);
    const CartesianPoint point = to_cartesian(landmark.anchor, anchor_pose, numbers, lever_scale());
    const double index = linearity_index(optical_centre(*landmark.anchor.camera, anchor_pose, lever_scale()),
                                         camera_centre(camera), point.position, numbers.z(), sigma);
    if (index > options_.linearity_index) continue;
    const JacobianPart<3> by_anchor = pose_part(state_, landmark.anchor_pose, point.wrt_anchor);
    std::vector<JacobianPart<Eigen::Dynamic>> parts = {{by_anchor.block, by_anchor.matrix},
                                                       {landmark.block, point.wrt_landmark}};
    if (const auto lever = lever_part<3>(point.wrt_lever_scale)) parts.push_back({lever->block, lever->matrix});
    state_.transform(landmark.block, point.position, BlockKind::kPoint, parts, Eigen::Matrix3d::Zero());
    landmark.form = LandmarkForm::kPoint;
    --past_pose_of(landmark.anchor_pose).anchored;
  }
  remove_blocks({});
  return impossible;
}

void Ekf::remove(std::span<const LandmarkId> landmarks) {
  std::vector<BlockId> blocks;
  for (const LandmarkId id : landmarks) {
    const FilterLandmark& landmark = landmarks_.at(id);
    if (landmark.anchored()) --past_pose_of(landmark.anchor_pose).anchored;
    if (landmark.in_state()) blocks.push_back(landmark.block);
    landmarks_.erase(id);
  }
  remove_blocks(std::move(blocks));
}

/// Removes the blocks given and the past poses nobody needs any more.
void Ekf::remove_blocks(std::vector<BlockId> blocks) {
  std::erase_if(past_poses_, [&blocks](const PastPose& past) {
    const bool needless = !past.keyframe && past.anchored == 0;
    if (needless) blocks.push_back(past.block);
    return needless;
  });
  state_.remove(blocks);
}

void Ekf::add_keyframe(common::Nanoseconds stamp, int max_keyframes) {
  past_pose_now(stamp).keyframe = true;
  std::vector<PastPose*> keyframes;
  for (PastPose& past : past_poses_) {
    if (past.keyframe) keyframes.push_back(&past);
  }
  if (static_cast<int>(keyframes.size()) <= max_keyframes) return;
  std::size_t spare = 1;
  common::Nanoseconds shortest = std::numeric_limits<common::Nanoseconds>::max();
  for (std::size_t i = 1; i + 1 < keyframes.size(); ++i) {
    const common::Nanoseconds gap = keyframes[i + 1]->stamp - keyframes[i - 1]->stamp;
    if (gap < shortest) {
      shortest = gap;
      spare = i;
    }
  }
  keyframes[spare]->keyframe = false;
  remove_blocks({});
}

double Ekf::distance_to(const common::Pose2& measured, const Eigen::Matrix3d& covariance) const {
  const Eigen::Vector3d residual = pose_residual(pose(), measured);
  return residual.dot((pose_covariance() + covariance).llt().solve(residual));
}

void Ekf::correct_pose(const common::Pose2& measured, const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d residual = pose_residual(pose(), measured);
  double factor = 1.0;
  while (factor < kMostInflation &&
         residual.dot((factor * pose_covariance() + covariance).llt().solve(residual)) > kPlausible) {
    factor *= kInflationStep;
  }
  state_.inflate(factor);
  const Eigen::MatrixXd gain_side = state_.covariance().middleCols(state_.offset(robot_), 3);
  const Eigen::LLT<Eigen::Matrix3d> llt(pose_covariance() + covariance);
  const Eigen::VectorXd step = gain_side * llt.solve(residual);
  state_.subtract_outer_product(llt.matrixL().solve(gain_side.transpose()).transpose());
  state_.correct(step);
  moved_ = true;
}

std::vector<LandmarkId> Ekf::set_pose(const common::Pose2& new_pose, const Eigen::Matrix3d& covariance) {
  std::vector<LandmarkId> without_depth;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.anchored()) without_depth.push_back(id);
  }
  remove(without_depth);
  set_planar_pose(state_, robot_, new_pose, covariance);
  moved_ = true;
  return without_depth;
}

std::optional<MapPoint> Ekf::map_point(LandmarkId landmark) const {
  const FilterLandmark& entry = landmarks_.at(landmark);
  if (entry.form == LandmarkForm::kFixed) return entry.fixed;
  if (entry.anchored()) return std::nullopt;
  return MapPoint{state_.mean(entry.block), state_.covariance(entry.block, entry.block)};
}

std::optional<Eigen::Vector3d> Ekf::likely_position(LandmarkId landmark) const {
  const FilterLandmark& entry = landmarks_.at(landmark);
  const Eigen::Vector3d numbers = numbers_of(entry);
  if (!entry.anchored()) return numbers;
  if (numbers.z() <= 0.0) return std::nullopt;
  return to_cartesian(entry.anchor, body_pose(state_, entry.anchor_pose), numbers, lever_scale()).position;
}

}  // namespace slamfuse::visual_slam
