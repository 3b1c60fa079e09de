// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory_evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "common/angle.hpp"
#include "common/offset_fit.hpp"
#include "common/trajectory_coverage.hpp"

namespace slamfuse::common {
namespace {

/// A hole of the reference this long, with a jump this far, is a carry.
constexpr Nanoseconds kCarryDuration = kNanosecondsPerSecond / 2;
constexpr double kCarryDistance = 0.5;

/// An estimated pose and where the robot was.
struct PosePair {
  Nanoseconds stamp;
  Pose2 estimate;
  Pose2 reference;
};

std::vector<PosePair> pairs_in_common(const Trajectory2& estimate, const Trajectory2& reference, Nanoseconds max_gap,
                                      Nanoseconds clock_offset = 0) {
  std::vector<PosePair> pairs;
  for (const StampedPose2& pose : estimate) {
    if (const std::optional<Pose2> truth = pose_at(reference, pose.stamp + clock_offset, max_gap)) {
      pairs.push_back({pose.stamp, pose.pose, *truth});
    }
  }
  return pairs;
}

/// When the carries start. `reference` is sorted.
std::vector<Nanoseconds> find_carries(const Trajectory2& reference) {
  std::vector<Nanoseconds> starts;
  if (is_sparse(reference)) return starts;
  for (std::size_t i = 1; i < reference.size(); ++i) {
    const double jump = (reference[i].pose.translation() - reference[i - 1].pose.translation()).norm();
    if (reference[i].stamp - reference[i - 1].stamp > kCarryDuration && jump > kCarryDistance) {
      starts.push_back(reference[i - 1].stamp);
    }
  }
  return starts;
}

Result<Similarity2> fit_alignment(const std::vector<PosePair>& pairs, Nanoseconds before, FitGroup group) {
  std::vector<Eigen::Vector2d> source;
  std::vector<Eigen::Vector2d> target;
  for (const PosePair& pair : pairs) {
    if (pair.stamp > before) continue;
    source.push_back(pair.estimate.translation());
    target.push_back(pair.reference.translation());
  }
  const std::optional<Similarity2> fit = fit_similarity(source, target, group);
  if (fit) return *fit;
  return invalid_input(
      fmt::format("the alignment cannot be fitted: {} poses in common with the reference before the first carry, "
                  "expected at least two in different places",
                  source.size()));
}

Nanoseconds before_first(const std::vector<Nanoseconds>& carries) {
  return carries.empty() ? std::numeric_limits<Nanoseconds>::max() : carries.front();
}

Result<Similarity2> choose_alignment(const std::vector<PosePair>& pairs, const std::vector<Nanoseconds>& carries,
                                     const EvaluationOptions& options) {
  const Nanoseconds first_carry = before_first(carries);
  switch (options.align) {
    case EvaluationAlignment::kNone:
      return Similarity2{};
    case EvaluationAlignment::kAs:
      return options.T_reference_estimate;
    case EvaluationAlignment::kSe2:
      return fit_alignment(pairs, first_carry, FitGroup::kRigid);
    case EvaluationAlignment::kSim2:
      return fit_alignment(pairs, first_carry, FitGroup::kSimilarity);
  }
  return Similarity2{};
}

/// A difference of the clocks with the offset that fits best under it.
struct ClockFit {
  Nanoseconds clock_offset = 0;
  OffsetFit offset;
  std::vector<PosePair> pairs;
};

std::optional<ClockFit> fit_at(Nanoseconds clock_offset, const Trajectory2& estimate, const Trajectory2& truth,
                               Nanoseconds before, Nanoseconds max_gap) {
  ClockFit fit{clock_offset, {}, pairs_in_common(estimate, truth, max_gap, clock_offset)};
  std::vector<Pose2> source;
  std::vector<Pose2> target;
  for (const PosePair& pair : fit.pairs) {
    if (pair.stamp > before) continue;
    source.push_back(pair.estimate);
    target.push_back(pair.reference);
  }
  const auto offset = fit_offset(source, target);
  if (!offset) return std::nullopt;
  fit.offset = *offset;
  return fit;
}

/// The best fit over all differences of the clocks: on a grid, refined around its best.
std::optional<ClockFit> fit_clocks(const Trajectory2& estimate, const Trajectory2& truth, Nanoseconds before,
                                   Nanoseconds max_gap) {
  constexpr Nanoseconds kCoarse = kNanosecondsPerSecond / 50;
  constexpr Nanoseconds kFine = kNanosecondsPerSecond / 2000;
  const std::size_t enough = pairs_in_common(estimate, truth, max_gap).size() / 2;
  std::optional<ClockFit> best;
  const auto consider = [&](Nanoseconds clock_offset) {
    auto fit = fit_at(clock_offset, estimate, truth, before, max_gap);
    const bool better = fit && fit->pairs.size() >= enough && (!best || fit->offset.rmse < best->offset.rmse);
    if (better) best = std::move(fit);
  };
  for (Nanoseconds at = -kMostClockOffset; at <= kMostClockOffset; at += kCoarse) consider(at);
  for (Nanoseconds step = kCoarse / 2; best && step >= kFine; step /= 2) {
    const Nanoseconds middle = best->clock_offset;
    consider(middle - step);
    consider(middle + step);
  }
  return best;
}

/// Mean relative translation error in percent over the sub-paths that start at each pair and end at the first pair at
/// least kSubPathLength further along the reference. `pairs` hold the aligned estimate.
std::optional<double> relative_error_percent(const std::vector<PosePair>& pairs,
                                             const std::vector<Nanoseconds>& carries) {
  const auto stretch_of = [&](const PosePair& pair) {
    return std::lower_bound(carries.begin(), carries.end(), pair.stamp) - carries.begin();
  };
  std::vector<double> travelled(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    travelled[i] = travelled[i - 1] + (pairs[i].reference.translation() - pairs[i - 1].reference.translation()).norm();
  }

  double sum = 0.0;
  std::size_t count = 0;
  std::size_t end = 0;
  for (std::size_t start = 0; start < pairs.size(); ++start) {
    while (end < pairs.size() && travelled[end] - travelled[start] < kSubPathLength) ++end;
    if (end == pairs.size()) break;
    if (stretch_of(pairs[start]) != stretch_of(pairs[end])) continue;
    const Pose2 moved = pairs[start].estimate.inverse() * pairs[end].estimate;
    const Pose2 truth = pairs[start].reference.inverse() * pairs[end].reference;
    sum += (truth.inverse() * moved).translation().norm() / (travelled[end] - travelled[start]);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return 100.0 * sum / static_cast<double>(count);
}

void sum_up_errors(const std::vector<PosePair>& pairs, TrajectoryAccuracy& accuracy) {
  double position_squares = 0.0;
  double heading_squares = 0.0;
  for (const auto& [stamp, estimate, reference] : pairs) {
    const double position = (estimate.translation() - reference.translation()).norm();
    const double heading = angle_difference(estimate.theta, reference.theta);
    accuracy.errors.push_back({stamp, position, heading});
    accuracy.ate_max_m = std::max(accuracy.ate_max_m, position);
    position_squares += position * position;
    heading_squares += heading * heading;
  }
  const auto count = static_cast<double>(pairs.size());
  accuracy.ate_rmse_m = std::sqrt(position_squares / count);
  accuracy.heading_rmse_deg = to_degrees(std::sqrt(heading_squares / count));
}

}  // namespace

std::string to_string(EvaluationAlignment align) {
  switch (align) {
    case EvaluationAlignment::kNone:
      return "none";
    case EvaluationAlignment::kSe2:
      return "se2";
    case EvaluationAlignment::kSim2:
      return "sim2";
    case EvaluationAlignment::kAs:
      return "as";
  }
  return "unknown";
}

Result<TrajectoryAccuracy> evaluate_trajectory(const Trajectory2& estimate, const Trajectory2& reference,
                                               const EvaluationOptions& options) {
  const Trajectory2 truth = sorted_by_stamp(reference);
  std::vector<PosePair> pairs = pairs_in_common(estimate, truth, options.max_reference_gap);
  if (pairs.empty()) {
    return invalid_input(fmt::format("estimate ({} poses) and reference ({} poses) have no time in common",
                                     estimate.size(), reference.size()));
  }
  const std::vector<Nanoseconds> carries = find_carries(truth);
  TrajectoryAccuracy accuracy;
  accuracy.align = options.align;
  if (options.fit_offset) {
    if (options.align != EvaluationAlignment::kSe2) {
      return usage_error("an offset can be fitted with the alignment se2 only, not with " + to_string(options.align));
    }
    auto fit = fit_clocks(estimate, truth, before_first(carries), options.max_reference_gap);
    if (!fit) return invalid_input("too few poses in common with the reference, or all in one place, to fit an offset");
    pairs = std::move(fit->pairs);
    accuracy.T_reference_estimate = {1.0, fit->offset.T_reference_estimate};
    accuracy.T_base_body = fit->offset.T_base_body;
    accuracy.clock_offset = fit->clock_offset;
  } else {
    const Result<Similarity2> alignment = choose_alignment(pairs, carries, options);
    if (!alignment) return tl::unexpected(alignment.error());
    accuracy.T_reference_estimate = *alignment;
  }
  for (PosePair& pair : pairs) pair.estimate = accuracy.T_reference_estimate * (pair.estimate * accuracy.T_base_body);

  sum_up_errors(pairs, accuracy);
  accuracy.rpe_percent = relative_error_percent(pairs, carries);
  accuracy.coverage = trajectory_coverage(estimate, truth);
  return accuracy;
}

}  // namespace slamfuse::common
