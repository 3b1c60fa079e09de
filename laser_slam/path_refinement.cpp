// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/path_refinement.hpp"

#include <algorithm>
#include <utility>

#include "laser_slam/parallel_for.hpp"
#include "laser_slam/pose_graph.hpp"
#include "laser_slam/submap.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kEnoughKnown = 0.5;    // share of a scan's points a submap must cover
constexpr int kSearchEvery = 4;         // keyframes: how often a wide search may be tried
constexpr double kPriorPosition = 0.3;  // [m] how far a loop may be from where the path has it now
constexpr double kPriorHeading = 0.2;   // [rad] the same

/// The poses of a run's graph: the keyframes first, then the submaps.
struct GraphPoses {
  std::vector<common::Pose2> values;
  std::size_t keyframes;

  const common::Pose2& of_keyframe(int index) const { return values[static_cast<std::size_t>(index)]; }
  const common::Pose2& of_submap(int index) const { return values[keyframes + static_cast<std::size_t>(index)]; }
};

class LoopSearch {
 public:
  LoopSearch(const std::vector<Keyframe>& keyframes, const LocalMapping& local, const ScanMatcher& matcher,
             const RefinementOptions& options, double least_path_apart)
      : keyframes_(keyframes),
        local_(local),
        matcher_(matcher),
        options_(options),
        least_path_apart_(least_path_apart) {}

  /// Loops from the submaps to a keyframe, as indices of graph variables.
  std::vector<PoseConstraint> loops_to(int keyframe, const GraphPoses& poses) const {
    std::vector<PoseConstraint> loops;
    const Keyframe& frame = keyframes_[static_cast<std::size_t>(keyframe)];
    if (!frame.mapped || frame.scan.empty()) return loops;
    const std::vector<int> near = near_submaps(keyframe, poses);
    if (near.empty()) return loops;
    const std::vector<Eigen::Vector2d> points = frame.scan.restore().match_points;
    for (const int submap : near) {
      const common::Pose2 start = expected(submap, keyframe, poses);
      const ScanMatch match = matcher_.match(map_of(submap), points, start, loose_prior(start));
      if (agrees(match.fit, points, options_.least_agreement)) {
        loops.push_back(loop(submap, keyframe, match, poses));
      }
    }
    if (loops.empty() && keyframe % kSearchEvery == 0) {
      // Where the drift is wider than the matcher's basin. A wide search finds wrong places more easily.
      const int submap = near.front();
      const ScanMatch match = matcher_.search(map_of(submap), points, expected(submap, keyframe, poses));
      if (agrees(match.fit, points, options_.search_agreement)) loops.push_back(loop(submap, keyframe, match, poses));
    }
    return loops;
  }

 private:
  /// The nearest submaps of another time, nearest first.
  std::vector<int> near_submaps(int keyframe, const GraphPoses& poses) const {
    const double path = keyframes_[static_cast<std::size_t>(keyframe)].path_length;
    const Eigen::Vector2d place = poses.of_keyframe(keyframe).translation();
    std::vector<std::pair<double, int>> found;
    for (std::size_t s = 0; s < local_.submaps.size(); ++s) {
      const std::vector<int>& members = local_.submaps[s].members;
      if (members.empty()) continue;
      const double first = keyframes_[static_cast<std::size_t>(members.front())].path_length;
      const double last = keyframes_[static_cast<std::size_t>(members.back())].path_length;
      if (path > first - least_path_apart_ && path < last + least_path_apart_) continue;
      const int middle = members[members.size() / 2];
      const double distance = (poses.of_keyframe(middle).translation() - place).norm();
      if (distance <= options_.reach) found.emplace_back(distance, static_cast<int>(s));
    }
    std::sort(found.begin(), found.end());
    if (found.size() > static_cast<std::size_t>(options_.submaps_per_scan)) {
      found.resize(static_cast<std::size_t>(options_.submaps_per_scan));
    }
    std::vector<int> result;
    for (const auto& [distance, submap] : found) result.push_back(submap);
    return result;
  }

  const GridMap& map_of(int submap) const { return local_.submaps[static_cast<std::size_t>(submap)].map; }

  static common::Pose2 expected(int submap, int keyframe, const GraphPoses& poses) {
    return poses.of_submap(submap).inverse() * poses.of_keyframe(keyframe);
  }

  static PosePrior loose_prior(const common::Pose2& mean) {
    const Eigen::Array3d deviations(kPriorPosition, kPriorPosition, kPriorHeading);
    return {mean, deviations.square().inverse().matrix().asDiagonal()};
  }

  static bool agrees(const ScanFit& fit, const std::vector<Eigen::Vector2d>& points, double least_agreement) {
    return fit.known >= kEnoughKnown * static_cast<double>(points.size()) && fit.agreement >= least_agreement;
  }

  PoseConstraint loop(int submap, int keyframe, const ScanMatch& match, const GraphPoses& poses) const {
    return {static_cast<int>(poses.keyframes) + submap, keyframe, match.pose, matcher_.gain() * match.fit.information,
            true};
  }

  const std::vector<Keyframe>& keyframes_;
  const LocalMapping& local_;
  const ScanMatcher& matcher_;
  const RefinementOptions& options_;
  double least_path_apart_;
};

}  // namespace

std::vector<common::Pose2> refine_path(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                                       const ScanMatcher& matcher, const MapOptions& map_options,
                                       const RefinementOptions& options, double least_path_apart, int threads) {
  const LocalMapping local = map_locally(keyframes, poses, matcher, map_options, options.submap_scans);
  const int count = static_cast<int>(keyframes.size());
  GraphPoses graph{poses, poses.size()};
  for (const Submap& submap : local.submaps) graph.values.push_back(graph.of_keyframe(submap.members.front()));

  std::vector<PoseConstraint> inner = local.motions;
  for (PoseConstraint membership : local.memberships) {
    membership.from += count;
    inner.push_back(membership);
  }
  const LoopSearch search(keyframes, local, matcher, options, least_path_apart);
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<std::vector<PoseConstraint>> loops(keyframes.size());
    parallel_for(count, threads, [&](int i, int) { loops[static_cast<std::size_t>(i)] = search.loops_to(i, graph); });
    std::vector<PoseConstraint> constraints = inner;
    for (const auto& found : loops) constraints.insert(constraints.end(), found.begin(), found.end());
    graph.values = optimise_poses(graph.values, constraints, options.loop_outlier);
  }
  graph.values.resize(keyframes.size());
  return graph.values;
}

GridMap draw_map(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                 const MapOptions& map_options) {
  GridMap map(map_options);
  InsertionScratch scratch;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    if (keyframes[i].mapped && !keyframes[i].scan.empty()) {
      map.insert(keyframes[i].scan.restore(), poses[i], keyframes[i].path_length, scratch);
    }
  }
  return map;
}

}  // namespace slamfuse::laser_slam
