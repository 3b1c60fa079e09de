// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/batch_adjustment.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/SparseCholesky>

#include "common/angle.hpp"
#include "visual_slam/projection.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr int kMostIterations = 100;
constexpr double kSmallestGain = 1e-9;  // of the cost, below which nothing moves any more: the scale is the last to
constexpr double kHuber = 2.5;          // standard deviations up to which a bearing counts in full
constexpr double kWrong = 3.3;          // standard deviations beyond which one bearing in 1000 is by chance
constexpr double kBehind = 1e3;         // cost of a bearing whose landmark would be behind the camera
constexpr double kKnown = 1e-6;         // what a systematic error that is known exactly may be
constexpr double kStill = 1e-4;         // [m], [rad] as well as a standing robot knows that it stands
constexpr double kFirstDamping = 1e-4;
constexpr double kMostDamping = 1e8;

using Triplets = std::vector<Eigen::Triplet<double>>;

double half_square(const Eigen::Vector3d& residual, const Eigen::Matrix3d& information) {
  return 0.5 * residual.dot(information * residual);
}

/// Columns of the unknowns a residual depends on, with the derivatives.
struct Part {
  int column;  // below 0: known
  Eigen::MatrixXd jacobian;
};

/// The normal equations H x = -g of a linearised problem.
class NormalEquations {
 public:
  explicit NormalEquations(int size) : gradient_(Eigen::VectorXd::Zero(size)) {}

  void add_cost(double cost) { cost_ += cost; }
  void add(std::span<const Part> parts, const Eigen::VectorXd& residual, const Eigen::MatrixXd& information,
           double cost) {
    cost_ += cost;
    for (const Part& row : parts) {
      if (row.column < 0) continue;
      const Eigen::MatrixXd weighted = row.jacobian.transpose() * information;
      gradient_.segment(row.column, row.jacobian.cols()) += weighted * residual;
      for (const Part& column : parts) {
        if (column.column < 0 || column.column > row.column) continue;  // the lower half will do
        const Eigen::MatrixXd block = weighted * column.jacobian;
        for (int i = 0; i < block.rows(); ++i) {
          for (int j = 0; j < block.cols(); ++j) triplets_.emplace_back(row.column + i, column.column + j, block(i, j));
        }
      }
    }
  }

  double cost() const { return cost_; }

  /// The step with the diagonal enlarged by a share of itself; empty when there is none.
  std::optional<Eigen::VectorXd> solve(double damping) const {
    const auto size = gradient_.size();
    Eigen::SparseMatrix<double> hessian(size, size);
    hessian.setFromTriplets(triplets_.begin(), triplets_.end());
    for (Eigen::Index i = 0; i < size; ++i) hessian.coeffRef(i, i) *= 1.0 + damping;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(hessian);
    if (factors.info() != Eigen::Success) return std::nullopt;
    Eigen::VectorXd step = -factors.solve(gradient_);
    if (!step.allFinite()) return std::nullopt;
    return step;
  }

 private:
  Triplets triplets_;
  Eigen::VectorXd gradient_;
  double cost_ = 0.0;
};

Eigen::Vector2d quarter_turn(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

BodyPose body_pose_of(const common::Pose2& pose) {
  BodyPose body;
  body.position = {pose.x, pose.y, 0.0};
  body.rotation = Eigen::AngleAxisd(pose.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return body;
}

/// By how much a step misses the odometry, in the frame the odometry leads to and the odometry's unit, with the
/// derivatives.
struct StepResidual {
  Eigen::Vector3d residual;
  Eigen::Matrix3d wrt_from;
  Eigen::Matrix3d wrt_to;
  Eigen::Matrix3d wrt_calibration;
  Eigen::Matrix3d covariance;
};

StepResidual step_residual(const common::Pose2& from, const common::Pose2& to, const common::Pose2& measured,
                           const OdometryCalibration& calibration, const MotionOptions& options) {
  const CalibratedIncrement calibrated = calibrate_increment(measured, calibration, options);
  const common::Pose2 reached = from * calibrated.increment;
  const Eigen::Matrix2d back = Eigen::Rotation2Dd(-reached.theta).toRotationMatrix();
  const Eigen::Vector2d miss = back * (to.translation() - reached.translation());
  StepResidual step;
  step.residual << miss, common::normalize_angle(to.theta - reached.theta);
  step.wrt_to.setIdentity();
  step.wrt_to.topLeftCorner<2, 2>() = back;
  Eigen::Matrix3d wrt_reached = -step.wrt_to;
  wrt_reached.topRightCorner<2, 1>() = -quarter_turn(miss);
  Eigen::Matrix3d reached_by_from = Eigen::Matrix3d::Identity();
  reached_by_from.topRightCorner<2, 1>() = quarter_turn(reached.translation() - from.translation());
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(from.theta).toRotationMatrix();
  step.wrt_from = wrt_reached * reached_by_from;
  step.wrt_calibration = wrt_reached * turn * calibrated.wrt_calibration;
  // The noise is that of the increment, in the axes it begins with; the residual is in those it ends with.
  Eigen::Matrix3d to_end = Eigen::Matrix3d::Identity();
  to_end.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-calibrated.increment.theta).toRotationMatrix();
  step.covariance = to_end * calibrated.noise * to_end.transpose() + kStill * kStill * Eigen::Matrix3d::Identity();
  // In the odometry's unit: measured in the map's, every miss would be smaller in a smaller map, and the map would
  // shrink as far as the promise on its scale lets it (robots 2 and 3 of MRCLAM: by a quarter).
  const double unit = 1.0 + calibration[0];
  step.residual.head<2>() /= unit;
  for (Eigen::Matrix3d* jacobian : {&step.wrt_from, &step.wrt_to, &step.wrt_calibration}) {
    jacobian->topRows<2>() /= unit;
  }
  step.wrt_calibration.topLeftCorner<2, 1>() -= step.residual.head<2>() / unit;
  return step;
}

}  // namespace

void BatchAdjustment::add_pose(const common::Pose2& odometry, const common::Pose2& believed) {
  odometry_.push_back(odometry);
  poses_.push_back(believed);
}

void BatchAdjustment::add_bearing(const Camera& camera, LandmarkId landmark, const Bearing& bearing) {
  sights_.push_back({poses_.size() - 1, &camera, landmark, bearing});
}

/// One adjustment: which unknown is in which column, what is left out, and the best so far.
class BatchAdjustment::Problem {
 public:
  Problem(const BatchAdjustment& drive, const std::map<LandmarkId, Eigen::Vector3d>& landmarks, int least_bearings)
      : drive_(drive),
        calibration_(3 * static_cast<int>(drive.odometry_.size())),
        size_(calibration_ + 3),
        wrong_(drive.sights_.size(), false) {
    std::map<LandmarkId, int> bearings;
    for (const Sight& sight : drive.sights_) ++bearings[sight.landmark];
    best_.poses = drive.poses_;
    for (const auto& [id, place] : landmarks) {
      if (bearings[id] < least_bearings) continue;
      best_.landmarks.emplace(id, place);
      columns_.emplace(id, size_);
      size_ += 3;
    }
  }

  const Result& best() const { return best_; }

  /// Goes downhill until nothing moves any more (Levenberg and Marquardt). Returns whether the equations could be
  /// solved.
  bool settle() {
    NormalEquations equations = linearise(best_);
    best_.cost = equations.cost();
    double damping = kFirstDamping;
    for (int i = 0; i < kMostIterations && damping < kMostDamping; ++i) {
      const std::optional<Eigen::VectorXd> step = equations.solve(damping);
      if (!step) return false;
      ++best_.iterations;
      Result next = moved(*step);
      NormalEquations there = linearise(next);
      next.cost = there.cost();
      if (!(next.cost < best_.cost)) {
        damping *= 10.0;
        continue;
      }
      const bool settled = best_.cost - next.cost < kSmallestGain * best_.cost;
      best_ = std::move(next);
      equations = std::move(there);
      damping *= 0.1;
      if (settled) break;
    }
    return true;
  }

  /// Leaves out the bearings that do not fit. Returns whether there are any.
  bool leave_out_wrong() {
    for (std::size_t i = 0; i < drive_.sights_.size(); ++i) {
      const Sight& sight = drive_.sights_[i];
      if (!columns_.contains(sight.landmark)) continue;
      const auto seen = project(sight, best_);
      wrong_[i] = !seen || (seen->point - sight.bearing.point).norm() > kWrong * sight.bearing.sigma;
      best_.wrong += wrong_[i] ? 1 : 0;
    }
    return best_.wrong > 0;
  }

 private:
  /// Below 0 for the first pose, which is known.
  static int column_of(std::size_t pose) { return 3 * (static_cast<int>(pose) - 1); }

  static std::optional<Projection> project(const Sight& sight, const Result& at) {
    return project_cartesian(*sight.camera, sight.bearing.row_shift, body_pose_of(at.poses[sight.pose]),
                             at.landmarks.at(sight.landmark));
  }

  NormalEquations linearise(const Result& at) const {
    NormalEquations equations(size_);
    add_promise(equations, at);
    for (std::size_t i = 0; i < drive_.odometry_.size(); ++i) {
      const StepResidual step =
          step_residual(at.poses[i], at.poses[i + 1], drive_.odometry_[i], at.calibration, drive_.options_);
      const Part parts[] = {
          {column_of(i), step.wrt_from}, {column_of(i + 1), step.wrt_to}, {calibration_, step.wrt_calibration}};
      const Eigen::Matrix3d information = step.covariance.inverse();
      equations.add(parts, step.residual, information, half_square(step.residual, information));
    }
    for (std::size_t i = 0; i < drive_.sights_.size(); ++i) {
      if (!wrong_[i] && columns_.contains(drive_.sights_[i].landmark)) add_sight(equations, drive_.sights_[i], at);
    }
    return equations;
  }

  /// What the options promise of the odometry's systematic errors.
  void add_promise(NormalEquations& equations, const Result& at) const {
    const MotionOptions& options = drive_.options_;
    const Eigen::Vector3d sigmas(options.distance_scale_sigma, options.turn_scale_sigma,
                                 common::to_radians(options.turn_per_distance_sigma));
    const Eigen::Matrix3d information = sigmas.cwiseMax(kKnown).cwiseAbs2().cwiseInverse().asDiagonal();
    const Part parts[] = {{calibration_, Eigen::Matrix3d::Identity()}};
    equations.add(parts, at.calibration, information, half_square(at.calibration, information));
  }

  void add_sight(NormalEquations& equations, const Sight& sight, const Result& at) const {
    const std::optional<Projection> seen = project(sight, at);
    if (!seen) {
      equations.add_cost(kBehind);
      return;
    }
    const Eigen::Vector2d residual = seen->point - sight.bearing.point;
    const double sigmas = residual.norm() / sight.bearing.sigma;
    const bool far = sigmas > kHuber;
    Eigen::Matrix<double, 2, 3> by_pose;
    by_pose << seen->wrt_robot.leftCols<2>(), seen->wrt_robot.rightCols<1>();
    const Part parts[] = {{column_of(sight.pose), by_pose}, {columns_.at(sight.landmark), seen->wrt_landmark}};
    const double information = (far ? kHuber / sigmas : 1.0) / (sight.bearing.sigma * sight.bearing.sigma);
    equations.add(parts, residual, information * Eigen::Matrix2d::Identity(),
                  far ? kHuber * (sigmas - 0.5 * kHuber) : 0.5 * sigmas * sigmas);
  }

  Result moved(const Eigen::VectorXd& step) const {
    Result to = best_;
    for (std::size_t i = 1; i < to.poses.size(); ++i) {
      const Eigen::Vector3d by = step.segment<3>(column_of(i));
      common::Pose2& pose = to.poses[i];
      pose = {pose.x + by.x(), pose.y + by.y(), common::normalize_angle(pose.theta + by.z())};
    }
    to.calibration += step.segment<3>(calibration_);
    for (auto& [id, place] : to.landmarks) place += step.segment<3>(columns_.at(id));
    return to;
  }

  const BatchAdjustment& drive_;
  int calibration_;  // column of the odometry's systematic errors
  int size_;
  std::map<LandmarkId, int> columns_;
  std::vector<bool> wrong_;  // as the drive's sights
  Result best_;
};

std::optional<BatchAdjustment::Result> BatchAdjustment::adjust(const std::map<LandmarkId, Eigen::Vector3d>& landmarks,
                                                               int least_bearings) const {
  Problem problem(*this, landmarks, least_bearings);
  if (!problem.settle()) return std::nullopt;
  if (problem.leave_out_wrong() && !problem.settle()) return std::nullopt;
  return problem.best();
}

}  // namespace slamfuse::visual_slam
