// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_command.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "fusion/fused_map.hpp"
#include "service/dds_publisher.hpp"
#include "service/output_folder.hpp"
#include "service/report.hpp"
#include "service/run_files.hpp"
#include "service/run_report.hpp"
#include "service/run_session.hpp"

namespace slamfuse::service {
namespace {

bool has_pose(const RunSummary& summary) {
  return std::any_of(summary.trajectories.begin(), summary.trajectories.end(),
                     [](const auto& named) { return named.name != "odometry" && !named.trajectory.empty(); });
}

std::string in_words(const RunSummary& summary, const OutputFolder& folder) {
  std::string text = verdict_in_words(report_of(summary)) + "\n";
  for (const auto& row : summary.accuracy) {
    text += fmt::format("  {:<13} ATE {:.3f} m rmse, {:.3f} m max, heading {:.2f} deg rmse, coverage {:.3f}\n",
                        row.name, row.accuracy.ate_rmse_m, row.accuracy.ate_max_m, row.accuracy.heading_rmse_deg,
                        row.accuracy.coverage);
  }
  return text + fmt::format("  {:.1f} s of recording in {:.1f} s, results in {}\n", summary.duration_s, summary.wall_s,
                            folder.path().string());
}

/// What a listener on DDS gets at the end: all in the laser map's frame. Refers to the summary's grid.
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

/// The publisher `--dds` asks for; none otherwise.
common::Result<std::unique_ptr<DdsPublisher>> make_publisher(const RunRequest& request, const RunSession& session) {
  if (!request.dds) return std::unique_ptr<DdsPublisher>();
  return DdsPublisher::create(request.configuration.service.dds, [&session] { return session.alignment(); });
}

void tell_failures(const DdsPublisher& publisher, RunSummary& summary) {
  if (publisher.failures() == 0) return;
  summary.log.events.push_back({summary.last_stamp, "dds", "send_failed",
                                fmt::format("{} messages could not be sent, the first: {}", publisher.failures(),
                                            publisher.first_failure()->message)});
}

}  // namespace

common::Result<std::string> run_recording(const RunRequest& request, PipelineObserver* progress,
                                          const std::atomic<bool>& stop, const std::function<void()>& on_started) {
  auto session = RunSession::create(request);
  if (!session) return tl::unexpected(session.error());
  std::error_code error;
  if (std::filesystem::equivalent(request.out, request.recording, error)) {
    return common::invalid_input(request.out.string() + ": the output folder must not be the recording itself");
  }
  on_started();
  const auto folder = OutputFolder::create(request.out, ResultKind::kRun);
  if (!folder) return tl::unexpected(folder.error());

  const auto publisher = make_publisher(request, *session);
  if (!publisher) return tl::unexpected(publisher.error());

  ObserverList observers;
  if (*publisher) observers.add(**publisher);
  if (progress != nullptr) observers.add(*progress);
  auto summary = session->run(&observers, stop);
  if (!summary) return tl::unexpected(summary.error());
  if (*publisher) tell_failures(**publisher, *summary);

  auto done = write_run_files(*summary, **folder);
  if (done) done = (*folder)->publish();
  if (!done) return tl::unexpected(done.error());
  if (summary->incomplete) {
    return tl::unexpected(common::Error{common::ErrorKind::kInterrupted,
                                        "interrupted; what was computed so far is in " + (*folder)->path().string()});
  }
  if (*publisher) (*publisher)->finish(final_state_of(*summary));
  if (!has_pose(*summary)) {
    return common::failed("no module could make a pose of this recording; see the events in " +
                          ((*folder)->path() / "metrics.json").string());
  }
  return in_words(*summary, **folder);
}

}  // namespace slamfuse::service
