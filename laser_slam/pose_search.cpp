// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/pose_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr std::size_t kFewestKept = 400;  // small maps are refined more densely: it costs nothing there
constexpr int kHalvings = 3;              // of the climbing steps
constexpr int kMostStepsALevel = 4;
constexpr double kDistinct = 0.5;       // [m] candidates closer than this ...
constexpr double kDistinctAngle = 0.3;  // [rad] ... and turned by less are one

/// Best first; of equals the one tried first.
template <class T, class Score>
void keep_best(std::vector<T>& items, std::size_t count, const Score& score) {
  count = std::min(count, items.size());
  const auto better = [&](const T& a, const T& b) {
    return score(a) != score(b) ? score(a) > score(b) : a.order < b.order;
  };
  std::partial_sort(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(count), items.end(), better);
  items.resize(count);
}

bool is_same_place(const common::Pose2& a, const common::Pose2& b) {
  return std::hypot(a.x - b.x, a.y - b.y) < kDistinct &&
         std::abs(common::angle_difference(a.theta, b.theta)) < kDistinctAngle;
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
    : field_(&field), options_(options), fine_model_(field, model), coarse_model_(field, model, options.step) {
  const int stride = std::max(1, static_cast<int>(std::lround(options.step / field.resolution())));
  for (int row = stride / 2; row < field.height(); row += stride) {
    for (int column = stride / 2; column < field.width(); column += stride) {
      if (!LikelihoodField::is_free(field.code(column, row))) continue;
      places_.push_back(field.origin() + Eigen::Vector2d(column + 0.5, row + 0.5) * field.resolution());
    }
  }
}

std::vector<PoseCandidate> PoseSearch::search(const std::vector<Eigen::Vector2d>& points) const {
  if (points.empty()) return {};
  std::vector<PoseCandidate> climbed;
  for (const PoseCandidate& start : coarse(points)) climbed.push_back(climb(points, start.pose));
  std::stable_sort(climbed.begin(), climbed.end(),
                   [](const PoseCandidate& a, const PoseCandidate& b) { return a.log_likelihood > b.log_likelihood; });
  std::vector<PoseCandidate> distinct;
  for (const PoseCandidate& candidate : climbed) {
    if (static_cast<int>(distinct.size()) >= options_.candidates) break;
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const PoseCandidate& other) {
      return is_same_place(candidate.pose, other.pose);
    });
    if (!known) distinct.push_back(candidate);
  }
  return distinct;
}

std::vector<PoseCandidate> PoseSearch::coarse(const std::vector<Eigen::Vector2d>& points) const {
  struct Tried {
    float score;
    std::uint32_t order;  // heading * places + place
  };
  const std::vector<Eigen::Vector2d> few = thin_points(points, options_.coarse_beams);
  const int headings = std::max(1, static_cast<int>(std::lround(2.0 * std::numbers::pi / options_.step_angle)));
  const auto heading_of = [&](std::size_t i) {
    return common::normalize_angle(2.0 * std::numbers::pi * static_cast<double>(i) / headings);
  };
  std::vector<Tried> tried;
  tried.reserve(places_.size() * static_cast<std::size_t>(headings));
  std::vector<std::array<int, 2>> offsets(few.size());
  const double scale = 1.0 / field_->resolution();
  for (std::size_t heading = 0; heading < static_cast<std::size_t>(headings); ++heading) {
    const Eigen::Matrix2d rotation = common::Pose2{0.0, 0.0, heading_of(heading)}.rotation();
    for (std::size_t i = 0; i < few.size(); ++i) {
      const Eigen::Vector2d turned = rotation * few[i] * scale;
      offsets[i] = {static_cast<int>(std::lround(turned.x())), static_cast<int>(std::lround(turned.y()))};
    }
    for (std::size_t place = 0; place < places_.size(); ++place) {
      const Eigen::Vector2d cell = (places_[place] - field_->origin()) * scale;
      const int column = static_cast<int>(cell.x());
      const int row = static_cast<int>(cell.y());
      float score = 0.0F;
      for (const auto& [dx, dy] : offsets) {
        score += coarse_model_.log_likelihood(field_->code(column + dx, row + dy));
      }
      tried.push_back({score, static_cast<std::uint32_t>(heading * places_.size() + place)});
    }
  }
  const auto share = static_cast<std::size_t>(options_.kept_share * static_cast<double>(tried.size()));
  keep_best(tried, std::max(kFewestKept, share), [](const Tried& t) { return t.score; });
  std::vector<PoseCandidate> best;
  best.reserve(tried.size());
  for (const Tried& t : tried) {
    const Eigen::Vector2d& place = places_[t.order % places_.size()];
    best.push_back({{place.x(), place.y(), heading_of(t.order / places_.size())}, static_cast<double>(t.score)});
  }
  return best;
}

PoseCandidate PoseSearch::climb(const std::vector<Eigen::Vector2d>& points, const common::Pose2& start) const {
  PoseCandidate best{start, fine_model_.log_likelihood(points, start)};
  double step = options_.step / 2.0;
  double turn = options_.step_angle / 2.0;
  for (int level = 0; level < kHalvings; ++level, step /= 2.0, turn /= 2.0) {
    for (int i = 0; i < kMostStepsALevel; ++i) {
      const PoseCandidate from = best;
      const std::array<Eigen::Vector3d, 6> moves = {
          {{step, 0, 0}, {-step, 0, 0}, {0, step, 0}, {0, -step, 0}, {0, 0, turn}, {0, 0, -turn}}};
      for (const Eigen::Vector3d& move : moves) {
        const common::Pose2 pose{from.pose.x + move.x(), from.pose.y + move.y(),
                                 common::normalize_angle(from.pose.theta + move.z())};
        const double score = fine_model_.log_likelihood(points, pose);
        if (score > best.log_likelihood) best = {pose, score};
      }
      if (best.log_likelihood == from.log_likelihood) break;
    }
  }
  return best;
}

}  // namespace slamfuse::laser_slam
