// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "common/angle.hpp"
#include "common/median.hpp"
#include "fusion/heldout_split.hpp"
#include "fusion/robust_fit.hpp"
#include "fusion/robust_statistics.hpp"
#include "fusion/seed004.hpp"

namespace slamfuse::fusion {
namespace {

using common::angle_difference;
using common::to_degrees;
using common::to_radians;

/// A ratio of losses larger than this tells nothing more; keeps infinities out of metrics.json.
constexpr double kLargestRatio = 1e6;

/// One method's map, before any verdict.
struct MethodFit {
  MappingMatrix mapping;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double runner_up_ratio = 0.0;
  bool essential_applied = false;
  std::string essential_report;
};

double ratio_of(double loss, double best) { return loss < kLargestRatio * best ? loss / best : kLargestRatio; }

MethodFit to_method_fit(const RobustFit& robust) {
  MethodFit result;
  result.mapping = to_mapping_matrix(robust.map);
  result.covariance = robust.covariance;
  result.runner_up_ratio = ratio_of(robust.runner_up_loss, robust.loss);
  return result;
}

RobustModel model_of(AlignmentMethod method) {
  if (method == AlignmentMethod::kRigid) return RobustModel::kRigid;
  return method == AlignmentMethod::kAffine ? RobustModel::kAffine : RobustModel::kSimilarity;
}

std::optional<MethodFit> fit(const std::vector<PosePair>& pairs, AlignmentMethod method,
                             const AlignmentOptions& options) {
  const double separation = to_radians(options.runner_up_separation);
  MethodFit result;
  if (method == AlignmentMethod::kSeed004) {
    const auto seed = fit_seed004(pairs, options.seed004, options.heldout_block, separation);
    if (!seed) return std::nullopt;
    result.mapping = seed->mapping;
    result.runner_up_ratio = ratio_of(seed->runner_up_loss, seed->loss);
    result.essential_applied = seed->essential_applied;
    result.essential_report = seed->essential_report;
    return result;
  }
  const auto robust = fit_robust(pairs, model_of(method), options.robust, separation);
  if (!robust) return std::nullopt;
  return to_method_fit(*robust);
}

/// The pairs, what the most flexible robust fit makes of them, and which of them therefore count in every method's
/// errors.
struct JudgedPairs {
  std::vector<PosePair> pairs;
  std::optional<RobustFit> affine;
  std::vector<bool> trusted;
};

JudgedPairs judge_pairs(std::vector<PosePair> pairs, const AlignmentOptions& options) {
  const double separation = to_radians(options.runner_up_separation);
  JudgedPairs judged{std::move(pairs), std::nullopt, {}};
  judged.affine = fit_robust(judged.pairs, RobustModel::kAffine, options.robust, separation);
  if (judged.affine) {
    judged.trusted = judged.affine->inliers;
  } else if (const auto fit = fit_robust(judged.pairs, RobustModel::kSimilarity, options.robust, separation)) {
    judged.trusted = fit->inliers;
  } else {
    judged.trusted.assign(judged.pairs.size(), true);
  }
  return judged;
}

template <class Keep>
double rmse_of(const std::vector<PosePair>& pairs, const PlanarAffine& map, Keep keep) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!keep(i)) continue;
    sum += (pairs[i].laser.translation() - map * pairs[i].visual.translation()).squaredNorm();
    ++count;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

double laser_path(const std::vector<PosePair>& pairs) {
  double length = 0.0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    length += (pairs[i].laser.translation() - pairs[i - 1].laser.translation()).norm();
  }
  return length;
}

/// Standard deviations [m] of the trusted laser positions along and across their main direction.
struct Spread {
  double wide = 0.0;
  double narrow = 0.0;
};

Spread spread_of(const std::vector<PosePair>& pairs, const std::vector<bool>& trusted) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!trusted[i]) continue;
    mean += pairs[i].laser.translation();
    count += 1.0;
  }
  if (count < 2.0) return {};
  mean /= count;
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!trusted[i]) continue;
    const Eigen::Vector2d offset = pairs[i].laser.translation() - mean;
    moments += offset * offset.transpose() / count;
  }
  const Eigen::Vector2d variances = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(moments).eigenvalues();
  return {std::sqrt(std::max(variances[1], 0.0)), std::sqrt(std::max(variances[0], 0.0))};
}

/// The turn from visual to laser headings: circular mean, then the median of what remains.
void measure_headings(const std::vector<PosePair>& pairs, const std::vector<bool>& trusted, Alignment& alignment) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  std::vector<double> turns;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!trusted[i]) continue;
    turns.push_back(angle_difference(pairs[i].laser.theta, pairs[i].visual.theta));
    sum += Eigen::Vector2d(std::cos(turns.back()), std::sin(turns.back()));
  }
  if (turns.empty()) return;
  const double mean = std::atan2(sum.y(), sum.x());
  for (double& turn : turns) turn = angle_difference(turn, mean);
  const double offset = common::median(turns);
  double square = 0.0;
  for (const double turn : turns) square += (turn - offset) * (turn - offset);
  alignment.heading_offset = common::normalize_angle(mean + offset);
  alignment.heading_rmse = std::sqrt(square / static_cast<double>(turns.size()));
}

/// Standard deviation of the mean scale, the root of the determinant; NaN where the map has no covariance.
double scale_sigma(const Alignment& alignment) {
  const Eigen::Matrix2d& a = alignment.map.linear;
  const double determinant = a.determinant();
  if (determinant == 0.0 || alignment.covariance.isZero(0.0)) return std::numeric_limits<double>::quiet_NaN();
  const Eigen::RowVector4d derivative = Eigen::RowVector4d(a(1, 1), -a(1, 0), -a(0, 1), a(0, 0)) *
                                        std::copysign(0.5, determinant) / std::sqrt(std::abs(determinant));
  return std::sqrt(std::max(0.0, (derivative * alignment.covariance.topLeftCorner<4, 4>()).dot(derivative)));
}

Alignment evaluate_method(const JudgedPairs& judged, AlignmentMethod method, const AlignmentOptions& options) {
  const auto& [pairs, affine, trusted_pairs] = judged;
  const auto& trusted = trusted_pairs;  // what a lambda may capture
  Alignment alignment;
  alignment.method = method;
  alignment.pairs = pairs.size();
  alignment.inliers = static_cast<std::size_t>(std::count(trusted.begin(), trusted.end(), true));
  const bool is_known = method == AlignmentMethod::kAffine && affine;
  const auto whole = is_known ? to_method_fit(*affine) : fit(pairs, method, options);
  if (!whole || !whole->mapping.planar().is_finite()) {
    alignment.reason = fmt::format("method {} finds no map through the {} pairs", to_string(method), pairs.size());
    alignment.heldout_rmse = std::numeric_limits<double>::infinity();
    return alignment;
  }
  alignment.mapping = whole->mapping;
  alignment.map = whole->mapping.planar();
  alignment.covariance = whole->covariance;
  alignment.runner_up_ratio = whole->runner_up_ratio;
  alignment.essential_applied = whole->essential_applied;
  alignment.essential_report = whole->essential_report;
  const AffineParts parts = take_apart(alignment.map);
  alignment.scale = parts.scale;
  alignment.scale_along_laser_axes = parts.scale_along_target_axes;
  alignment.mean_scale = parts.mean_scale;
  alignment.scale_sigma = scale_sigma(alignment);
  alignment.rotation_deg = to_degrees(parts.rotation);
  measure_headings(pairs, trusted, alignment);

  alignment.rmse = rmse_of(pairs, alignment.map, [&](std::size_t i) { return trusted[i]; });
  alignment.rmse_all = rmse_of(pairs, alignment.map, [](std::size_t) { return true; });
  const HeldoutSplit split(pairs.size(), options.heldout_block);
  const auto training = fit(split.training(pairs), method, options);
  alignment.heldout_rmse = training ? rmse_of(pairs, training->mapping.planar(),
                                              [&](std::size_t i) { return trusted[i] && split.held_out(i); })
                                    : std::numeric_limits<double>::infinity();
  return alignment;
}

/// How far the last quarter of the pairs is off under a fit to those before, as the poses to come will be. Of all of
/// them, outliers or not: a path that begins to bend is one; by the median, so that some may be outliers.
double forward_error(const JudgedPairs& judged, const Alignment& alignment, const AlignmentOptions& options) {
  const auto known = static_cast<std::ptrdiff_t>(judged.pairs.size() * 3 / 4);
  const auto training = fit({judged.pairs.begin(), judged.pairs.begin() + known}, alignment.method, options);
  if (!training) return alignment.heldout_rmse;
  constexpr double kRmsOverMedian = 1.2011;  // of Rayleigh's distribution
  std::vector<double> distances;
  for (auto pair = judged.pairs.begin() + known; pair != judged.pairs.end(); ++pair) {
    distances.push_back((pair->laser.translation() - training->mapping.planar() * pair->visual.translation()).norm());
  }
  return kRmsOverMedian * common::median(std::move(distances));
}

/// Whether the scales of a map are what drift makes of 1.
bool keeps_scale(const Alignment& alignment, const AlignmentOptions& options) {
  const double sigma = std::sqrt(alignment.covariance.topLeftCorner<4, 4>().diagonal().maxCoeff());
  const double allowed = options.scale_tolerance + 3.0 * sigma;
  return (alignment.scale - Eigen::Vector2d::Ones()).cwiseAbs().maxCoeff() < allowed;
}

Alignment evaluate(const JudgedPairs& judged, double straightness_ratio, const AlignmentOptions& options,
                   VisualScale scale) {
  if (options.method != AlignmentMethod::kAuto) return evaluate_method(judged, options.method, options);
  Alignment scaled = evaluate_method(judged, AlignmentMethod::kSimilarity, options);
  if (straightness_ratio >= options.affine_straightness_ratio) {
    Alignment affine = evaluate_method(judged, AlignmentMethod::kAffine, options);
    if (affine.heldout_rmse < options.affine_gain * scaled.heldout_rmse) scaled = std::move(affine);
  }
  const bool rigid = scale == VisualScale::kMetric && keeps_scale(scaled, options);
  return rigid ? evaluate_method(judged, AlignmentMethod::kRigid, options) : scaled;
}

/// Why the alignment must not be used; empty when nothing speaks against it.
std::string objection(const Alignment& alignment, const Spread& spread, const AlignmentOptions& options) {
  if (alignment.straightness_ratio < options.min_straightness_ratio) {
    return fmt::format(
        "the path is too straight to fix the angle and both scales: its spread is {:.3f} m across and "
        "{:.3f} m along, ratio {:.4f}, needed {:.4f}",
        spread.narrow, spread.wide, alignment.straightness_ratio, options.min_straightness_ratio);
  }
  if (!alignment.reason.empty()) return alignment.reason;
  if (alignment.runner_up_ratio < options.min_runner_up_ratio) {
    return fmt::format(
        "the angle is ambiguous: another angle, at least {:.0f} deg away, fits almost as well (ratio of "
        "the losses {:.3f}, needed {:.3f})",
        options.runner_up_separation, alignment.runner_up_ratio, options.min_runner_up_ratio);
  }
  const double inlier_share = static_cast<double>(alignment.inliers) / static_cast<double>(alignment.pairs);
  if (inlier_share < options.min_inlier_share) {
    return fmt::format("only {} of {} pairs agree with a common map, needed is a share of {:.2f}", alignment.inliers,
                       alignment.pairs, options.min_inlier_share);
  }
  const double largest_error = options.max_relative_error * std::hypot(spread.wide, spread.narrow);
  if (!(alignment.heldout_rmse <= largest_error)) {
    return fmt::format(
        "the trajectories do not fit each other: held-out pairs are off by {:.3f} m rmse, allowed are "
        "{:.3f} m",
        alignment.heldout_rmse, largest_error);
  }
  return {};
}

Alignment refuse(Alignment alignment, std::string reason) {
  alignment.accepted = false;
  alignment.reason = std::move(reason);
  return alignment;
}

bool all_finite(const common::Trajectory2& trajectory) {
  return std::all_of(trajectory.begin(), trajectory.end(), [](const auto& pose) { return pose.pose.is_finite(); });
}

/// What is taken to lie between the two sensors, see Alignment.
struct Offsets {
  double clock_offset = 0.0;
  Eigen::Vector2d lever_arm = Eigen::Vector2d::Zero();
};

/// Pairs by the laser's clock; the laser's poses are moved to the visual's tracked point, which the map has to meet.
std::vector<PosePair> pairs_of(const common::Trajectory2& laser, const common::Trajectory2& visual,
                               const Offsets& offsets, const PairingOptions& options) {
  common::Trajectory2 by_laser_clock = visual;
  for (auto& pose : by_laser_clock) pose.stamp += common::from_seconds(offsets.clock_offset);
  std::vector<PosePair> pairs = pair_trajectories(laser, by_laser_clock, options);
  for (PosePair& pair : pairs) {
    const Eigen::Vector2d tracked = pair.laser * offsets.lever_arm;
    pair.laser.x = tracked.x();
    pair.laser.y = tracked.y();
  }
  return pairs;
}

Alignment align_as_told(const common::Trajectory2& laser, const common::Trajectory2& visual,
                        const AlignmentOptions& options, VisualScale scale, const Offsets& offsets) {
  Alignment nothing;
  nothing.method = options.method;
  nothing.clock_offset = offsets.clock_offset;
  nothing.lever_arm = offsets.lever_arm;
  if (!all_finite(laser)) return refuse(nothing, "the laser trajectory has a pose that is not finite");
  if (!all_finite(visual)) return refuse(nothing, "the visual trajectory has a pose that is not finite");

  if (laser.empty()) return refuse(nothing, "there is no laser trajectory");
  if (visual.empty()) return refuse(nothing, "there is no visual trajectory");

  const std::vector<PosePair> all_pairs = pairs_of(laser, visual, offsets, options.pairing);
  nothing.pairs = all_pairs.size();
  if (all_pairs.empty()) return refuse(nothing, "the trajectories have no poses at common times");
  const auto needed = static_cast<std::size_t>(options.min_pairs);
  if (all_pairs.size() < needed) {
    return refuse(nothing, fmt::format("too few pairs: {}, needed {}", all_pairs.size(), needed));
  }
  const double path = laser_path(all_pairs);
  if (path < options.min_path) {
    return refuse(nothing, fmt::format("the path is too short: {:.3f} m, needed {:.3f} m", path, options.min_path));
  }
  std::vector<PosePair> pairs =
      evenly_spread(without_standstill(all_pairs, options.pairing), static_cast<std::size_t>(options.most_pairs));
  nothing.pairs = pairs.size();
  if (pairs.size() < needed) {
    return refuse(nothing, fmt::format("too few pairs where the robot moved: {}, needed {}", pairs.size(), needed));
  }

  const JudgedPairs judged = judge_pairs(std::move(pairs), options);
  const Spread spread = spread_of(judged.pairs, judged.trusted);
  const double straightness_ratio = spread.wide > 0.0 ? spread.narrow / spread.wide : 0.0;
  Alignment best = evaluate(judged, straightness_ratio, options, scale);
  best.straightness_ratio = straightness_ratio;
  best.clock_offset = offsets.clock_offset;
  best.lever_arm = offsets.lever_arm;
  best.forward_rmse = forward_error(judged, best, options);
  const std::string against = objection(best, spread, options);
  if (!against.empty()) return refuse(best, against);
  best.accepted = true;
  best.reason = fmt::format("{} of {} pairs agree, {:.3f} m rmse on held-out pairs, {:.3f} m on the last quarter",
                            best.inliers, best.pairs, best.heldout_rmse, best.forward_rmse);
  return best;
}

}  // namespace

common::Pose2 Alignment::to_laser(const common::Pose2& visual) const {
  common::Pose2 laser{0.0, 0.0, common::normalize_angle(visual.theta + heading_offset)};
  const Eigen::Vector2d position = map * visual.translation() - laser.rotation() * lever_arm;
  laser.x = position.x();
  laser.y = position.y();
  return laser;
}

common::Pose2 Alignment::to_visual(const common::Pose2& laser) const {
  const Eigen::Vector2d position = map.inverse() * (laser * lever_arm);
  return {position.x(), position.y(), common::normalize_angle(laser.theta - heading_offset)};
}

Alignment align_trajectories(const common::Trajectory2& laser, const common::Trajectory2& visual,
                             const AlignmentOptions& options, VisualScale scale) {
  Alignment plain = align_as_told(laser, visual, options, scale, {});
  // Seed 004 knows of no offsets.
  const bool of_the_paper = options.method == AlignmentMethod::kSeed004;
  if (!plain.accepted || !options.offsets.estimate || of_the_paper) return plain;
  plain.offsets =
      estimate_sensor_offsets(laser, visual, common::from_seconds(options.pairing.max_gap), options.offsets);
  if (!plain.offsets) return plain;
  const auto clear = significant(*plain.offsets, options.offsets);
  if (!clear) return plain;
  Alignment better = align_as_told(laser, visual, options, scale, {clear->clock_offset, clear->lever_arm});
  if (!better.accepted || better.heldout_rmse >= options.offset_gain * plain.heldout_rmse) return plain;
  better.offsets = plain.offsets;
  return better;
}

double typical_error(const common::Trajectory2& laser, const common::Trajectory2& visual, const Alignment& alignment,
                     const AlignmentOptions& options) {
  std::vector<double> distances;
  const Offsets offsets{alignment.clock_offset, alignment.lever_arm};
  for (const PosePair& pair : pairs_of(laser, visual, offsets, options.pairing)) {
    distances.push_back((pair.laser.translation() - alignment.map * pair.visual.translation()).norm());
  }
  return distances.empty() ? std::numeric_limits<double>::infinity() : common::median(std::move(distances));
}

Eigen::Matrix2d Alignment::position_covariance(const Eigen::Vector2d& visual) const {
  Eigen::Matrix<double, 2, 6> jacobian;  // of map * visual by the six numbers of the map
  jacobian << visual.transpose(), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, visual.transpose(), 0.0, 1.0;
  return jacobian * covariance * jacobian.transpose();
}

common::Trajectory2 to_laser_frame(const common::Trajectory2& visual, const Alignment& alignment) {
  common::Trajectory2 aligned;
  aligned.reserve(visual.size());
  const common::Nanoseconds shift = common::from_seconds(alignment.clock_offset);
  for (const common::StampedPose2& pose : visual) {
    aligned.push_back({pose.stamp + shift, alignment.to_laser(pose.pose)});
  }
  return aligned;
}

}  // namespace slamfuse::fusion
