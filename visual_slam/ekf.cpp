// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/ekf.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <Eigen/Cholesky>

#include "common/angle.hpp"
#include "common/median.hpp"
#include "visual_slam/consensus.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kBelievedSpeed = 9.0;   // squared standard deviations
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
  for (Eigen::Index i = 0; i < std::ssize(measurements); ++i) {
    s.block<2, 2>(2 * i, 2 * i) += measurements[static_cast<std::size_t>(i)].noise;
  }
  return s;
}

Eigen::VectorXd stacked_residuals(std::span<const LinearMeasurement> measurements) {
  Eigen::VectorXd residuals(2 * static_cast<int>(measurements.size()));
  for (Eigen::Index i = 0; i < std::ssize(measurements); ++i) {
    residuals.segment<2>(2 * i) = measurements[static_cast<std::size_t>(i)].residual;
  }
  return residuals;
}

}  // namespace

Ekf::Ekf(const FilterOptions& filter, const MotionOptions& motion)
    : options_(filter), motion_(make_motion_model(motion)) {
  options_.linearity_index *= motion_->bearing_margin();  // so that a margin does not delay the landmarks
  robot_ = motion_->append_robot(state_);
  motion_parameters_ = motion_->append_parameters(state_);
}

void Ekf::predict(const MotionStep& given) {
  MotionStep step = given;
  step.speed_is_told = metres_are_told_;
  const common::Pose2 before = pose();
  const std::optional<Slip> slip = motion_->slip(state_, robot_, motion_parameters_, step);
  if (motion_->predict(state_, robot_, motion_parameters_, step)) past_poses_.robot_moved();
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
  for (Eigen::Index i = 0; i < std::ssize(measurements); ++i) {
    by_slip.middleRows<2>(2 * i) =
        measurements[static_cast<std::size_t>(i)].jacobian.front().matrix * wheels_.since_image()->pose;
  }
  if (by_slip.cwiseAbs().maxCoeff() < std::sqrt(measurements.front().noise(0, 0))) return SlipWatch::Verdict::kNothing;
  const SlipWatch::Verdict verdict = wheels_.judge(slip_evidence(stacked_residuals(measurements), covariance, by_slip,
                                                                 chi_square_gate_2(options_.gate_probability)));
  const Slip& slip = *wheels_.since_image();
  if (verdict == SlipWatch::Verdict::kSlip) slip_admission_.begin(state_, robot_, motion_parameters_, slip);
  if (verdict == SlipWatch::Verdict::kGrip) slip_admission_.end(state_, robot_, motion_parameters_, slip);
  return verdict;
}

Bearing Ekf::with_margin(Bearing bearing) const {
  bearing.sigma *= motion_->bearing_margin();
  return bearing;
}

std::optional<LinearMeasurement> Ekf::linearise(const Camera& camera, const Measurement& measurement) const {
  return model().linearise(camera, landmarks_.at(measurement.landmark), measurement.bearing);
}

std::optional<Prediction> Ekf::predict_bearing(const Camera& camera, LandmarkId landmark,
                                               const BodyPose& row_shift) const {
  return model().predict(camera, landmarks_.at(landmark), row_shift);
}

std::optional<Prediction> Ekf::predict_point(const Camera& camera, const MapPoint& point,
                                             const BodyPose& row_shift) const {
  return model().predict(camera, {.form = LandmarkForm::kFixed, .fixed = point}, row_shift);
}

bool Ekf::depth_is_known(const FilterLandmark& landmark) const {
  if (!landmark.anchored()) return true;
  const double rho = state_.mean(landmark.block)[2];
  return std::sqrt(state_.covariance(landmark.block, landmark.block)(2, 2)) < options_.known_depth * rho;
}

bool Ekf::knows_depth(LandmarkId landmark) const {
  const FilterLandmark& entry = landmarks_.at(landmark);
  return entry.form != LandmarkForm::kWaiting && depth_is_known(entry);
}

/// For each measurement, whether its parallax may teach the robot. Without metres somebody has to
/// say how fast the robot moves, and while few depths are known that is the inverse depth landmarks start with.
std::vector<bool> Ekf::which_depths_count(std::span<const Measurement> measurements,
                                          std::span<const std::size_t> accepted) const {
  std::vector<bool> count(measurements.size());
  int known = 0;
  for (const std::size_t i : accepted) {
    count[i] = depth_is_known(landmarks_.at(measurements[i].landmark));
    known += count[i] ? 1 : 0;
  }
  if (!is_metric() && known < options_.min_known_depths) count.assign(count.size(), true);
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

UpdateReport Ekf::update(const Camera& camera, std::span<const Measurement> given) {
  std::vector<Measurement> measurements(given.begin(), given.end());
  for (Measurement& measurement : measurements) measurement.bearing = with_margin(measurement.bearing);
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
    std::vector<double> known = known_inverse_depths(camera, measurements, accepted);
    if (static_cast<int>(known.size()) >= options_.min_known_depths) {
      typical_inverse_depth_ = common::median(std::move(known));
    }
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
  if (is_metric()) return true;
  // Nobody but the landmarks knows how fast the robot moves, and a pair of sights says nothing without that.
  const auto known = std::count_if(landmarks_.begin(), landmarks_.end(),
                                   [](const auto& entry) { return entry.second.form == LandmarkForm::kPoint; });
  return known >= options_.min_known_depths;
}

/// Whether a bearing of a waiting landmark fits; makes the landmark a point when it and its first sight allow.
bool Ekf::pair_up(const Camera& camera, const Measurement& measurement) {
  FilterLandmark& landmark = landmarks_.at(measurement.landmark);
  const PairOutcome outcome = visual_slam::pair_up(state_, model(), landmark, camera, measurement.bearing, options_);
  if (outcome == PairOutcome::kEntered) past_poses_.release(landmark.anchor_pose);
  return outcome != PairOutcome::kMisfit;
}

void Ekf::add_landmark(LandmarkId landmark, const Camera& camera, const Bearing& given, common::Nanoseconds stamp) {
  const Bearing bearing = with_margin(given);
  const BlockId anchor = past_poses_.anchor(state_, robot_, stamp);
  FilterLandmark entry{.form = LandmarkForm::kWaiting,
                       .block = 0,
                       .anchor_pose = anchor,
                       .anchor = {&camera, bearing.row_shift},
                       .first = bearing,
                       .inverse_depth = options_.initial_inverse_depth};
  if (!starts_delayed()) {
    entry.form = LandmarkForm::kInverseDepth;
    entry.block = enter_by_inverse_depth(state_, bearing, guessed_depth());
  }
  landmarks_.emplace(landmark, std::move(entry));
}

std::vector<double> Ekf::known_inverse_depths(const Camera& camera, std::span<const Measurement> measurements,
                                              std::span<const std::size_t> accepted) const {
  const Eigen::Vector3d axis = body_pose(state_, robot_).rotation * camera.R_base_camera.col(2);
  std::vector<double> inverse_depths;
  for (const std::size_t i : accepted) {
    const LandmarkId id = measurements[i].landmark;
    if (!depth_is_known(landmarks_.at(id))) continue;
    const std::optional<Eigen::Vector3d> at = likely_position(id);
    if (!at) continue;
    const double depth = axis.dot(*at - camera_centre(camera));
    if (depth > 0.0) inverse_depths.push_back(1.0 / depth);
  }
  return inverse_depths;
}

/// The median of what the last image saw is what a new landmark in it has, probably.
DepthGuess Ekf::guessed_depth() const {
  if (!typical_inverse_depth_) return {options_.initial_inverse_depth, options_.inverse_depth_sigma};
  return {*typical_inverse_depth_, options_.scene_depth_sigma * *typical_inverse_depth_};
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
    switch (make_cartesian(state_, model(), landmark, camera, options_.linearity_index)) {
      case Conversion::kImpossible:
        impossible.push_back(id);
        break;
      case Conversion::kDone:
        past_poses_.release(landmark.anchor_pose);
        break;
      case Conversion::kNotYet:
        break;
    }
  }
  remove_blocks({});
  return impossible;
}

void Ekf::remove(std::span<const LandmarkId> landmarks) {
  std::vector<BlockId> blocks;
  for (const LandmarkId id : landmarks) {
    const FilterLandmark& landmark = landmarks_.at(id);
    if (landmark.anchored()) past_poses_.release(landmark.anchor_pose);
    if (landmark.in_state()) blocks.push_back(landmark.block);
    landmarks_.erase(id);
  }
  remove_blocks(std::move(blocks));
}

/// Removes the blocks given and the past poses nobody needs any more.
void Ekf::remove_blocks(std::vector<BlockId> blocks) {
  const std::vector<BlockId> needless = past_poses_.take_needless();
  blocks.insert(blocks.end(), needless.begin(), needless.end());
  state_.remove(blocks);
}

void Ekf::add_keyframe(common::Nanoseconds stamp, int max_keyframes) {
  past_poses_.add_keyframe(state_, robot_, stamp);
  if (past_poses_.limit_keyframes(max_keyframes)) remove_blocks({});
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
  past_poses_.robot_moved();
}

void Ekf::let_scale_drift(std::span<const LandmarkId> landmarks, double sigma) {
  if (!motion_->metric_speed(state_, motion_parameters_)) return;
  Eigen::VectorXd grown = Eigen::VectorXd::Zero(state_.size());
  const Eigen::Vector3d here = body_pose(state_, robot_).position;
  for (const LandmarkId id : landmarks) {
    const FilterLandmark& landmark = landmarks_.at(id);
    if (!landmark.in_state()) continue;
    const int offset = state_.offset(landmark.block);
    if (landmark.anchored()) {
      grown[offset + 2] = -state_.mean(landmark.block)[2];
    } else {
      grown.segment<3>(offset) = state_.mean(landmark.block) - here;
    }
  }
  grown[state_.offset(motion_parameters_) + kSpeedIndex] = state_.mean(motion_parameters_)[kSpeedIndex];
  state_.add_error(sigma * grown);
}

void Ekf::doubt_speed(double sigma) {
  if (!motion_->metric_speed(state_, motion_parameters_)) return;
  Eigen::VectorXd error = Eigen::VectorXd::Zero(state_.size());
  error[state_.offset(motion_parameters_) + kSpeedIndex] = sigma;
  state_.add_error(error);
}

bool Ekf::correct_speed(double measured, double sigma) {
  const std::optional<MotionNumber> speed = motion_->metric_speed(state_, motion_parameters_);
  if (!speed) return false;
  const int offset = state_.offset(motion_parameters_);
  const Eigen::Index size = speed->wrt_parameters.size();
  const Eigen::VectorXd gain_side = state_.covariance().middleCols(offset, size) * speed->wrt_parameters.transpose();
  const double variance = speed->wrt_parameters.dot(gain_side.segment(offset, size)) + sigma * sigma;
  const double residual = measured - speed->value;
  if (residual * residual > kBelievedSpeed * variance) return false;
  state_.subtract_outer_product(gain_side / std::sqrt(variance));
  state_.correct(gain_side * (residual / variance));
  past_poses_.robot_moved();
  return true;
}

std::vector<LandmarkId> Ekf::set_pose(const common::Pose2& new_pose, const Eigen::Matrix3d& covariance) {
  std::vector<LandmarkId> without_depth;
  for (const auto& [id, landmark] : landmarks_) {
    if (landmark.anchored()) without_depth.push_back(id);
  }
  remove(without_depth);
  set_planar_pose(state_, robot_, new_pose, covariance);
  past_poses_.robot_moved();
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
  const Eigen::Vector3d numbers = entry.numbers(state_);
  if (!entry.anchored()) return numbers;
  if (numbers.z() <= 0.0) return std::nullopt;
  return to_cartesian(entry.anchor, body_pose(state_, entry.anchor_pose), numbers, lever_scale()).position;
}

}  // namespace slamfuse::visual_slam
