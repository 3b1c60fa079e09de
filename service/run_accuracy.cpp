// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_accuracy.hpp"

#include <algorithm>

#include "common/recording.hpp"
#include "common/trajectory_coverage.hpp"

namespace slamfuse::service {
namespace {

/// The part of a trajectory between two stamps.
common::Trajectory2 between(const common::Trajectory2& trajectory, common::Nanoseconds first,
                            common::Nanoseconds last) {
  common::Trajectory2 part;
  for (const auto& pose : trajectory) {
    if (pose.stamp >= first && pose.stamp <= last) part.push_back(pose);
  }
  return part;
}

}  // namespace

common::Result<void> judge(const RunRequest& request, const std::set<std::string>& free_scale, RunSummary& summary) {
  const auto truth = request.live ? common::Result<common::Trajectory2>()
                                  : common::read_ground_truth(request.recording, request.recording_options);
  if (!truth) return tl::unexpected(truth.error());
  summary.truth = between(common::sorted_by_stamp(*truth), summary.first_stamp, summary.last_stamp);

  for (const auto& [source, counters] : summary.counters) {
    const auto trajectory = summary.log.trajectories.find(source);
    if (trajectory == summary.log.trajectories.end() || trajectory->second.empty()) {
      summary.coverage[source] = 0.0;
    } else if (request.live) {  // where the trajectory is thinned
      const auto covered = static_cast<double>(summary.log.covered.at(source));
      const auto time = static_cast<double>(summary.last_stamp - summary.first_stamp);
      summary.coverage[source] = time > 0.0 ? std::min(1.0, covered / time) : 1.0;
    } else if (summary.truth.empty()) {
      summary.coverage[source] = common::time_coverage(trajectory->second, summary.first_stamp, summary.last_stamp);
    } else {
      summary.coverage[source] = common::trajectory_coverage(trajectory->second, summary.truth);
    }
  }
  if (summary.truth.empty()) return {};
  for (const auto& [name, trajectory] : summary.trajectories) {
    // A trajectory with too little in common with the truth has no accuracy; its row is left out.
    common::EvaluationOptions options;
    if (free_scale.contains(name)) options.align = common::EvaluationAlignment::kSim2;
    if (auto accuracy = common::evaluate_trajectory(trajectory, summary.truth, options)) {
      summary.accuracy.push_back({name, std::move(*accuracy)});
    }
  }
  return {};
}

}  // namespace slamfuse::service
