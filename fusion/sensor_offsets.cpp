// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/sensor_offsets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Cholesky>

#include "common/angle.hpp"
#include "common/median.hpp"
#include "fusion/robust_fit.hpp"
#include "fusion/robust_statistics.hpp"
#include "fusion/trajectory_pairing.hpp"

namespace slamfuse::fusion {
namespace {

using common::angle_difference;
using common::Nanoseconds;
using common::Trajectory2;

/// Over this time [s] turns are compared, and speeds measured.
constexpr double kTurnTime = 0.5;
/// Step of the search for the clock offset [s]; Gauss-Newton does the rest.
constexpr double kSearchStep = 0.02;
/// So many turns are compared in the search.
constexpr std::size_t kMostTurns = 250;
/// Fewer moments in common fix nothing.
constexpr std::size_t kFewestMoments = 30;
/// Robust standard deviation from the median of absolute values.
constexpr double kSigmaOfMedian = 1.4826;
constexpr int kIterations = 15;

enum Parameter { kA, kB, kTx, kTy, kLeverX, kLeverY, kClock, kYaw, kParameters };
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;
using Row = Eigen::Matrix<double, 1, kParameters>;

/// How far the body turned over kTurnTime about moments that come in rising order.
class Turns {
 public:
  Turns(const Trajectory2& trajectory, Nanoseconds max_gap)
      : before_(trajectory, max_gap), after_(trajectory, max_gap) {}

  std::optional<double> at(Nanoseconds stamp) {
    const Nanoseconds half = common::from_seconds(kTurnTime / 2.0);
    const auto before = before_.at(stamp - half);
    const auto after = after_.at(stamp + half);
    if (!before || !after) return std::nullopt;
    return angle_difference(after->theta, before->theta);
  }

 private:
  common::PoseCursor before_;
  common::PoseCursor after_;
};

/// A truncated mean: a tenth may be outliers, e.g. steps of one map.
double mean_misfit(std::vector<double>& misfits) {
  if (misfits.size() < kFewestMoments) return std::numeric_limits<double>::infinity();
  const auto kept = static_cast<std::ptrdiff_t>(misfits.size() - misfits.size() / 10);
  std::nth_element(misfits.begin(), misfits.begin() + kept - 1, misfits.end());
  return std::accumulate(misfits.begin(), misfits.begin() + kept, 0.0) / static_cast<double>(kept);
}

/// The offset that, added to the visual stamps, makes the laser's turns fit best.
std::optional<double> search_clock_offset(const Trajectory2& laser, const Trajectory2& visual,
                                          const Trajectory2& moments, Nanoseconds max_gap, double most) {
  const int steps = static_cast<int>(std::ceil(most / kSearchStep));
  const auto offset = [&](std::size_t n) { return kSearchStep * (static_cast<int>(n) - steps); };
  std::vector<std::vector<double>> misfits(static_cast<std::size_t>(2 * steps + 1));
  Turns laser_turns(laser, max_gap);
  Turns visual_turns(visual, max_gap);
  for (const auto& moment : evenly_spread(moments, kMostTurns)) {
    const auto turn = visual_turns.at(moment.stamp);
    if (!turn) continue;
    for (std::size_t n = 0; n < misfits.size(); ++n) {
      const auto other = laser_turns.at(moment.stamp + common::from_seconds(offset(n)));
      if (other) misfits[n].push_back(std::abs(angle_difference(*other, *turn)));
    }
  }
  std::optional<double> best;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < misfits.size(); ++n) {
    const double misfit = mean_misfit(misfits[n]);
    if (misfit < smallest) {
      smallest = misfit;
      best = offset(n);
    }
  }
  return best;
}

/// What one moment says: two coordinates and a heading, and how they change with the parameters.
struct Moment {
  Eigen::Vector3d residual;
  Eigen::Matrix<double, 3, kParameters> jacobian;
};

std::optional<Moment> moment_of(common::PoseCursor& laser, const common::StampedPose2& visual, const Vector& x) {
  const Nanoseconds then = visual.stamp + common::from_seconds(x[kClock]);
  const Nanoseconds half = common::from_seconds(kTurnTime / 4.0);
  const auto before = laser.at(then - half);
  const auto at = laser.at(then);
  const auto after = laser.at(then + half);
  if (!at || !before || !after) return std::nullopt;
  const double seconds = common::to_seconds(2 * half);
  const Eigen::Vector2d speed = (after->translation() - before->translation()) / seconds;
  const double turn_rate = angle_difference(after->theta, before->theta) / seconds;

  const Eigen::Vector2d p = visual.pose.translation();
  const Eigen::Vector2d lever = at->rotation() * Eigen::Vector2d(x[kLeverX], x[kLeverY]);
  Moment moment;
  moment.jacobian.setZero();
  moment.residual.head<2>() =
      at->translation() + lever -
      Eigen::Vector2d(x[kA] * p.x() - x[kB] * p.y() + x[kTx], x[kB] * p.x() + x[kA] * p.y() + x[kTy]);
  moment.jacobian.block<2, 2>(0, kA) << -p.x(), p.y(), -p.y(), -p.x();
  moment.jacobian.block<2, 2>(0, kTx) = -Eigen::Matrix2d::Identity();
  moment.jacobian.block<2, 2>(0, kLeverX) = at->rotation();
  moment.jacobian.block<2, 1>(0, kClock) = speed + turn_rate * Eigen::Vector2d(-lever.y(), lever.x());
  const double phi = std::atan2(x[kB], x[kA]);
  const double square = x[kA] * x[kA] + x[kB] * x[kB];
  moment.residual.z() = angle_difference(at->theta + x[kYaw], visual.pose.theta + phi);
  moment.jacobian(2, kYaw) = 1.0;
  moment.jacobian(2, kClock) = turn_rate;
  moment.jacobian(2, kA) = x[kB] / square;
  moment.jacobian(2, kB) = -x[kA] / square;
  return moment;
}

std::vector<Moment> moments_of(const Trajectory2& laser, const Trajectory2& visual, const Vector& x,
                               Nanoseconds max_gap) {
  std::vector<Moment> moments;
  moments.reserve(visual.size());
  common::PoseCursor places(laser, max_gap);
  for (const auto& pose : visual) {
    if (const auto moment = moment_of(places, pose, x)) moments.push_back(*moment);
  }
  return moments;
}

/// Noise of the positions (one coordinate) and of the headings.
struct Noise {
  double position = 0.0;
  double heading = 0.0;
};

Noise noise_of(const std::vector<Moment>& moments) {
  std::vector<double> positions;
  std::vector<double> headings;
  for (const Moment& moment : moments) {
    positions.push_back(moment.residual.head<2>().norm());
    headings.push_back(std::abs(moment.residual.z()));
  }
  constexpr double kRayleighMedian = 1.1774100225154747;
  constexpr double kSmallest = 1e-6;
  return {std::max(common::median(std::move(positions)) / kRayleighMedian, kSmallest),
          std::max(kSigmaOfMedian * common::median(std::move(headings)), kSmallest)};
}

/// Weighted normal equations, and what they leave.
struct Step {
  Matrix information = Matrix::Zero();
  Vector gradient = Vector::Zero();
};

Step step_of(const std::vector<Moment>& moments, const Noise& noise) {
  Step step;
  for (const Moment& moment : moments) {
    const double position = tukey_weight(moment.residual.head<2>().squaredNorm(), std::sqrt(2.0) * noise.position) /
                            (noise.position * noise.position);
    const double heading =
        tukey_weight(moment.residual.z() * moment.residual.z(), noise.heading) / (noise.heading * noise.heading);
    const Eigen::Vector3d weights(position, position, heading);
    step.information += moment.jacobian.transpose() * weights.asDiagonal() * moment.jacobian;
    step.gradient += moment.jacobian.transpose() * weights.asDiagonal() * moment.residual;
  }
  return step;
}

/// (1 + r) / (1 - r) for the first autocorrelation r of the residuals' coordinate: how many times fewer independent
/// ones there are.
double correlation_inflation(const std::vector<Moment>& moments, const Noise& noise) {
  constexpr double kLargest = 0.95;
  double lagged = 0.0;
  double total = 0.0;
  for (std::size_t i = 1; i < moments.size(); ++i) {
    const Eigen::Vector2d a = moments[i - 1].residual.head<2>();
    const Eigen::Vector2d b = moments[i].residual.head<2>();
    if (std::max(a.norm(), b.norm()) > kTukeyConstant * noise.position) continue;
    lagged += a.dot(b);
    total += b.squaredNorm();
  }
  const double r = total > 0.0 ? std::clamp(lagged / total, 0.0, kLargest) : 0.0;
  return (1.0 + r) / (1.0 - r);
}

double rmse_of(const std::vector<Moment>& moments, const Noise& noise) {
  double sum = 0.0;
  double count = 0.0;
  for (const Moment& moment : moments) {
    const double distance = moment.residual.head<2>().norm();
    if (distance > kTukeyConstant * noise.position) continue;
    sum += distance * distance;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

Trajectory2 shifted(Trajectory2 trajectory, double seconds) {
  for (auto& pose : trajectory) pose.stamp += common::from_seconds(seconds);
  return trajectory;
}

/// Where Gauss-Newton begins: the robust similarity at the clock offset found, no lever arm.
std::optional<Vector> start(const Trajectory2& laser, const Trajectory2& moments, double clock_offset,
                            Nanoseconds max_gap) {
  const auto pairs = without_standstill(
      pair_trajectories(laser, shifted(moments, clock_offset), {.max_gap = common::to_seconds(max_gap)}), {});
  const auto fit = fit_robust(pairs, RobustModel::kSimilarity, {}, 1.0);
  if (!fit) return std::nullopt;
  Vector x = Vector::Zero();
  x[kA] = fit->map.linear(0, 0);
  x[kB] = fit->map.linear(1, 0);
  x[kTx] = fit->map.translation.x();
  x[kTy] = fit->map.translation.y();
  x[kClock] = clock_offset;
  std::vector<double> sines;
  std::vector<double> cosines;
  const double phi = std::atan2(x[kB], x[kA]);
  for (const PosePair& pair : pairs) {
    const double yaw = pair.visual.theta + phi - pair.laser.theta;
    sines.push_back(std::sin(yaw));
    cosines.push_back(std::cos(yaw));
  }
  x[kYaw] = std::atan2(common::median(std::move(sines)), common::median(std::move(cosines)));
  return x;
}

}  // namespace

std::optional<SensorOffsets> estimate_sensor_offsets(const Trajectory2& laser, const Trajectory2& visual,
                                                     Nanoseconds max_gap, const SensorOffsetOptions& options) {
  if (laser.size() < kFewestMoments || visual.size() < kFewestMoments) return std::nullopt;
  const Trajectory2 sorted_laser = common::sorted_by_stamp(laser);
  const Trajectory2 sorted_visual = common::sorted_by_stamp(visual);
  const Trajectory2 moments = evenly_spread(sorted_visual, static_cast<std::size_t>(options.samples));
  const auto clock = search_clock_offset(sorted_laser, sorted_visual, moments, max_gap, options.most_clock_offset);
  if (!clock) return std::nullopt;
  const auto begin = start(sorted_laser, moments, *clock, max_gap);
  if (!begin) return std::nullopt;

  Vector x = *begin;
  std::vector<Moment> told = moments_of(sorted_laser, moments, x, max_gap);
  for (int n = 0; n < kIterations; ++n) {
    if (told.size() < kFewestMoments) return std::nullopt;
    const Step step = step_of(told, noise_of(told));
    const Eigen::LDLT<Matrix> solver(step.information);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
    Vector change = solver.solve(step.gradient);
    if (!change.allFinite()) return std::nullopt;
    // The laser's path is not straight over more than a moment.
    change[kClock] = std::clamp(change[kClock], -0.1, 0.1);
    x -= change;
    if (std::abs(x[kClock]) > options.most_clock_offset + kSearchStep) return std::nullopt;
    told = moments_of(sorted_laser, moments, x, max_gap);
    constexpr double kSettled = 1e-7;
    if (change.norm() < kSettled) break;
  }
  if (told.size() < kFewestMoments) return std::nullopt;
  const Noise noise = noise_of(told);
  const Step last = step_of(told, noise);
  const Eigen::LDLT<Matrix> solver(last.information);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const Matrix covariance = correlation_inflation(told, noise) * solver.solve(Matrix::Identity());
  if (!covariance.allFinite() || (covariance.diagonal().array() <= 0.0).any()) return std::nullopt;

  SensorOffsets offsets;
  offsets.clock_offset = x[kClock];
  offsets.clock_sigma = std::sqrt(covariance(kClock, kClock));
  offsets.lever_arm = {x[kLeverX], x[kLeverY]};
  offsets.lever_sigma = {std::sqrt(covariance(kLeverX, kLeverX)), std::sqrt(covariance(kLeverY, kLeverY))};
  offsets.yaw = common::normalize_angle(x[kYaw]);
  offsets.yaw_sigma = std::sqrt(covariance(kYaw, kYaw));
  offsets.rmse = rmse_of(told, noise);
  return offsets;
}

std::optional<SensorOffsets> significant(const SensorOffsets& offsets, const SensorOffsetOptions& options) {
  SensorOffsets kept = offsets;
  const bool clock = std::abs(offsets.clock_offset) > options.significance * offsets.clock_sigma &&
                     std::abs(offsets.clock_offset) > options.smallest_clock_offset;
  const bool lever = offsets.lever_arm.cwiseQuotient(offsets.lever_sigma).norm() > options.significance &&
                     offsets.lever_arm.norm() > options.smallest_lever_arm;
  if (!clock && !lever) return std::nullopt;
  if (!clock) kept.clock_offset = 0.0;
  if (!lever) kept.lever_arm.setZero();
  return kept;
}

std::string describe(const SensorOffsets& offsets) {
  return fmt::format(
      "visual stamps are {:.1f} +- {:.1f} ms early, the visual's tracked point is at ({:.3f} +- {:.3f}, {:.3f} +- "
      "{:.3f}) "
      "m in the laser's body frame, turned by {:.2f} +- {:.2f} deg",
      1e3 * offsets.clock_offset, 1e3 * offsets.clock_sigma, offsets.lever_arm.x(), offsets.lever_sigma.x(),
      offsets.lever_arm.y(), offsets.lever_sigma.y(), common::to_degrees(offsets.yaw),
      common::to_degrees(offsets.yaw_sigma));
}

}  // namespace slamfuse::fusion
