// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_files.hpp"

#include <array>

#include <fmt/format.h>

#include "common/tum.hpp"
#include "service/map_bundle.hpp"
#include "service/metrics.hpp"
#include "service/report.hpp"
#include "service/run_report.hpp"

namespace slamfuse::service {
namespace {

/// A text as one field of a CSV line that any reader takes, quoting or not.
std::string csv_field(std::string text) {
  for (char& c : text) {
    if (c == ',') c = ';';
    if (c == '"') c = '\'';
    if (c == '\n' || c == '\r') c = ' ';
  }
  return text;
}

MapBundle map_bundle_of(const RunSummary& summary) {
  MapBundle bundle;
  bundle.program_version = program_version();
  bundle.seed = summary.seed;
  bundle.recording = summary.recording;
  bundle.incomplete = summary.incomplete;
  bundle.grid = summary.grid ? &*summary.grid : nullptr;
  bundle.laser_state = summary.laser_state;
  bundle.landmarks = summary.landmarks;
  bundle.keyframes = summary.keyframes;
  bundle.cameras = summary.cameras;
  bundle.alignment = summary.alignment;
  constexpr std::array<std::pair<const char*, const char*>, 3> kPaths{
      {{"laser_final", "laser"}, {"visual_final", "visual"}, {"fused_final", "fused"}}};
  for (const auto& [name, trajectory] : summary.trajectories) {
    for (const auto& [final_name, map_name] : kPaths) {
      if (name == final_name) bundle.trajectories[map_name] = trajectory;
    }
  }
  return bundle;
}

}  // namespace

common::Result<void> write_run_files(const RunSummary& summary, OutputFolder& folder) {
  for (const auto& [name, trajectory] : summary.trajectories) {
    const std::string text = trajectory_file(trajectory, summary.seed, summary.incomplete);
    if (auto written = folder.write(name + ".tum", text); !written) return written;
  }
  if (auto written = folder.write("status.csv", status_csv(summary.log.status)); !written) return written;
  if (auto written = write_map_bundle(map_bundle_of(summary), folder.staging() / "map"); !written) return written;
  if (auto written = folder.write("report.html", make_report(report_of(summary))); !written) return written;
  return folder.write("metrics.json", json_text(metrics_of(summary)));
}

std::string trajectory_file(const common::Trajectory2& trajectory, std::uint64_t seed, bool incomplete) {
  return kTrajectoryFileStart +
         fmt::format(" {} seed {}{}\n", program_version(), seed, incomplete ? " incomplete" : "") +
         common::to_tum(trajectory);
}

std::string status_csv(const std::vector<fusion::StatusEntry>& status) {
  std::string csv = "stamp_ns,source,state,score,reasons\n";
  for (const auto& entry : status) {
    std::string reasons;
    for (const auto& reason : entry.reasons) reasons += (reasons.empty() ? "" : "; ") + csv_field(reason);
    csv += fmt::format("{},{},{},{:.3f},{}\n", entry.stamp, common::to_string(entry.source), to_string(entry.state),
                       entry.score, reasons);
  }
  return csv;
}

}  // namespace slamfuse::service
