// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_conclusion.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "fusion/fused_map.hpp"
#include "service/report.hpp"
#include "service/run_report.hpp"

namespace slamfuse::service {

bool has_pose(const RunSummary& summary) {
  return std::any_of(summary.trajectories.begin(), summary.trajectories.end(),
                     [](const auto& named) { return named.name != "odometry" && !named.trajectory.empty(); });
}

std::string in_words(const RunSummary& summary, const std::filesystem::path& folder) {
  std::string text = verdict_in_words(report_of(summary)) + "\n";
  for (const auto& row : summary.accuracy) {
    text += fmt::format("  {:<13} ATE {:.3f} m rmse, {:.3f} m max, heading {:.2f} deg rmse, coverage {:.3f}\n",
                        row.name, row.accuracy.ate_rmse_m, row.accuracy.ate_max_m, row.accuracy.heading_rmse_deg,
                        row.accuracy.coverage);
  }
  return text + fmt::format("  {:.1f} s of recording in {:.1f} s, results in {}\n", summary.duration_s, summary.wall_s,
                            folder.string());
}

DdsFinalState final_state_of(const RunSummary& summary) {
  DdsFinalState state;
  if (summary.grid) state.map = &*summary.grid;
  const bool aligned = summary.alignment && summary.alignment->accepted;
  for (const auto& [name, trajectory] : summary.trajectories) {
    if (name == "laser_final") state.laser = trajectory;
    if (name == "visual_final" && aligned) state.visual = fusion::to_laser_frame(trajectory, *summary.alignment);
    if (name == "fused_final") state.fused = trajectory;
  }
  if (aligned) state.landmarks = fusion::to_laser_frame(summary.landmarks, *summary.alignment);
  return state;
}

void tell_failures(const DdsPublisher& publisher, RunSummary& summary) {
  const UnsentMessages& unsent = publisher.unsent();
  if (unsent.count == 0) return;
  summary.log.events.push_back(
      {summary.last_stamp, "dds", "send_failed",
       fmt::format("{} messages could not be sent, the first: {}", unsent.count, unsent.first->message)});
}

}  // namespace slamfuse::service
