// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/pose_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr std::size_t kFewestKept = 400;  // small maps are refined more densely: it costs nothing there
constexpr int kHalvings = 3;              // of the climbing steps
constexpr int kMostStepsALevel = 4;
constexpr double kMet = 0.1;            // [m] poses that climbed to closer than this ...
constexpr double kMetAngle = 0.06;      // [rad] ... and are turned by less climb on together
constexpr int kFineStarts = 8;          // poses that climb with all beams, for each candidate wanted
constexpr int kTraced = 3;              // of these whose beams are followed
constexpr double kDistinct = 0.5;       // [m] candidates closer than this ...
constexpr double kDistinctAngle = 0.3;  // [rad] ... and turned by less are one

/// Best first, of poses closer than these bounds only the best, at most `most`. Of equals the earlier one is the
/// better.
std::vector<PoseCandidate> distinct(std::vector<PoseCandidate> candidates, double metres, double radians, int most) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const PoseCandidate& a, const PoseCandidate& b) { return a.log_likelihood > b.log_likelihood; });
  std::vector<PoseCandidate> kept;
  for (const PoseCandidate& candidate : candidates) {
    if (static_cast<int>(kept.size()) >= most) break;
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const PoseCandidate& other) {
      return std::hypot(candidate.pose.x - other.pose.x, candidate.pose.y - other.pose.y) < metres &&
             std::abs(common::angle_difference(candidate.pose.theta, other.pose.theta)) < radians;
    });
    if (!known) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace

std::vector<Eigen::Vector2d> thin_points(const std::vector<Eigen::Vector2d>& points, int most) {
  const auto wanted = static_cast<std::size_t>(most);
  if (points.size() <= wanted) return points;
  std::vector<Eigen::Vector2d> thinned;
  thinned.reserve(wanted);
  for (std::size_t i = 0; i < wanted; ++i) thinned.push_back(points[i * points.size() / wanted]);
  return thinned;
}

PoseSearch::PoseSearch(const LikelihoodField& field, const BeamModelOptions& model, const PoseSearchOptions& options)
    : field_(&field),
      options_(options),
      fine_model_(field, model),
      places_(field, BeamModel(field, model, options.step),
              std::max(1, static_cast<int>(std::lround(options.step / field.resolution()))), options.coarse_beams) {}

std::vector<PoseCandidate> PoseSearch::search(const std::vector<Eigen::Vector2d>& points,
                                              const Eigen::Vector2d& mount) const {
  if (points.empty()) return {};
  const std::vector<Eigen::Vector2d> few = thin_points(points, options_.coarse_beams);
  std::vector<PoseCandidate> rough;
  for (const PoseCandidate& start : coarse(few)) rough.push_back(climb(few, start.pose, 1));
  std::vector<PoseCandidate> fine;
  for (const PoseCandidate& start : distinct(std::move(rough), kMet, kMetAngle, kFineStarts * options_.candidates)) {
    fine.push_back(climb(points, start.pose, kHalvings));
  }
  std::vector<PoseCandidate> traced =
      distinct(std::move(fine), kDistinct, kDistinctAngle, kTraced * options_.candidates);
  for (PoseCandidate& candidate : traced) {
    candidate.log_likelihood = fine_model_.traced_log_likelihood(points, mount, candidate.pose);
  }
  return distinct(std::move(traced), kDistinct, kDistinctAngle, options_.candidates);
}

std::vector<PoseCandidate> PoseSearch::coarse(const std::vector<Eigen::Vector2d>& points) const {
  const int headings = std::max(1, static_cast<int>(std::lround(2.0 * std::numbers::pi / options_.step_angle)));
  const auto heading_of = [&](int i) { return common::normalize_angle(2.0 * std::numbers::pi * i / headings); };
  std::vector<std::array<int, 2>> offsets(points.size());
  std::vector<std::vector<std::uint16_t>> scores(static_cast<std::size_t>(headings));
  // How many poses have a score, to know without sorting which one the best share begins with.
  std::vector<std::size_t> poses_of(std::numeric_limits<std::uint16_t>::max() + 1);
  for (int heading = 0; heading < headings; ++heading) {
    const Eigen::Matrix2d rotation = common::Pose2{0.0, 0.0, heading_of(heading)}.rotation() / field_->resolution();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2d turned = rotation * points[i];
      offsets[i] = {static_cast<int>(std::lround(turned.x())), static_cast<int>(std::lround(turned.y()))};
    }
    std::vector<std::uint16_t>& at_heading = scores[static_cast<std::size_t>(heading)];
    places_.score(offsets, at_heading);
    for (const std::uint16_t score : at_heading) ++poses_of[score];
  }
  const auto tried = static_cast<double>(places_.places()) * headings;
  const std::size_t wanted = std::max(kFewestKept, static_cast<std::size_t>(options_.kept_share * tried));
  std::size_t least = poses_of.size() - 1;
  std::size_t better = 0;  // poses that score more than `least`
  while (least > 0 && better + poses_of[least] < wanted) better += poses_of[least--];
  std::size_t equal = wanted - better;  // of those that score `least` the first ones
  std::vector<PoseCandidate> best;
  for (int heading = 0; heading < headings; ++heading) {
    const std::vector<std::uint16_t>& at_heading = scores[static_cast<std::size_t>(heading)];
    for (std::size_t place = 0; place < at_heading.size(); ++place) {
      const std::uint16_t score = at_heading[place];
      if (score < least || (score == least && equal == 0)) continue;
      if (score == least) --equal;
      const Eigen::Vector2d position = places_.position(place);
      best.push_back({{position.x(), position.y(), heading_of(heading)}, places_.log_likelihood(score, points.size())});
    }
  }
  return best;
}

PoseCandidate PoseSearch::climb(const std::vector<Eigen::Vector2d>& points, const common::Pose2& start,
                                int levels) const {
  PoseCandidate best{start, fine_model_.log_likelihood(points, start)};
  double step = options_.step / 2.0;
  double turn = options_.step_angle / 2.0;
  for (int level = 0; level < levels; ++level, step /= 2.0, turn /= 2.0) {
    for (int i = 0; i < kMostStepsALevel; ++i) {
      const PoseCandidate from = best;
      const std::array<Eigen::Vector3d, 6> moves = {
          {{step, 0, 0}, {-step, 0, 0}, {0, step, 0}, {0, -step, 0}, {0, 0, turn}, {0, 0, -turn}}};
      for (const Eigen::Vector3d& move : moves) {
        const common::Pose2 pose{from.pose.x + move.x(), from.pose.y + move.y(), from.pose.theta + move.z()};
        const double score = fine_model_.log_likelihood(points, pose);
        if (score > best.log_likelihood) best = {pose, score};
      }
      if (best.log_likelihood == from.log_likelihood) break;
    }
  }
  best.pose.theta = common::normalize_angle(best.pose.theta);
  return best;
}

}  // namespace slamfuse::laser_slam
