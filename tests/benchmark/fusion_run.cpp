// SPDX-License-Identifier: BSD-3-Clause
#include "benchmark/fusion_run.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "common/angle.hpp"
#include "common/replay.hpp"
#include "service/run_session.hpp"

namespace slamfuse {

common::Result<service::RunSummary> run(const FusionRun& run) {
  const service::RunRequest& request = run.request;
  auto recording = common::open_recording(request.recording, request.recording_options);
  if (!recording) return tl::unexpected(recording.error());
  if (run.fault) {
    std::unique_ptr<common::Recording> donor;
    if (run.fault->kind == FaultKind::kReplaced) {
      auto opened = common::open_recording(run.donor);
      if (!opened) return tl::unexpected(opened.error());
      donor = std::move(*opened);
    }
    recording = with_fault(std::move(*recording), *run.fault, std::move(donor));
  }
  if (run.cut_from && run.cut_to) {
    const common::Nanoseconds start = (*recording)->info().first_stamp;
    recording = without_time(std::move(*recording), common::to_seconds(*run.cut_from - start),
                             common::to_seconds(*run.cut_to - start));
  }
  common::ReplayOptions options;
  options.from = request.from;
  options.to = request.to;
  options.arrival_delay = request.arrival_delay;
  options.stamp_offset = request.stamp_offset;
  auto replayed = common::replay(std::move(*recording), options);
  if (!replayed) return tl::unexpected(replayed.error());
  auto session = service::RunSession::create(request, std::move(*replayed));
  if (!session) return tl::unexpected(session.error());
  return session->run(nullptr, std::atomic<bool>(false));
}

common::Trajectory2 trajectory_of(const service::RunSummary& summary, const std::string& name) {
  for (const auto& named : summary.trajectories) {
    if (named.name == name) return named.trajectory;
  }
  return {};
}

double ate_of(const service::RunSummary& summary, const std::string& name) {
  for (const auto& named : summary.accuracy) {
    if (named.name == name) return named.accuracy.ate_rmse_m;
  }
  return NAN;
}

common::Trajectory2 between(const common::Trajectory2& trajectory, common::Nanoseconds from, common::Nanoseconds to) {
  common::Trajectory2 part;
  std::copy_if(trajectory.begin(), trajectory.end(), std::back_inserter(part),
               [&](const common::StampedPose2& pose) { return pose.stamp >= from && pose.stamp < to; });
  return part;
}

std::vector<common::PoseError> errors_under(const common::Similarity2& T_truth_map, const common::Trajectory2& estimate,
                                            const common::Trajectory2& truth) {
  common::EvaluationOptions options;
  options.align = common::EvaluationAlignment::kAs;
  options.T_reference_estimate = T_truth_map;
  const auto accuracy = common::evaluate_trajectory(estimate, truth, options);
  return accuracy ? accuracy->errors : std::vector<common::PoseError>();
}

common::Result<common::Similarity2> fit_to_truth(const common::Trajectory2& estimate,
                                                 const common::Trajectory2& truth) {
  const auto accuracy = common::evaluate_trajectory(estimate, truth);
  if (!accuracy) return tl::unexpected(accuracy.error());
  return accuracy->T_reference_estimate;
}

bool is_right(const common::PoseError& error) {
  return error.position <= 0.5 && std::abs(error.heading) <= common::to_radians(10.0);
}

}  // namespace slamfuse
