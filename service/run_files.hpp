// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/trajectory.hpp"
#include "fusion/status.hpp"
#include "service/output_folder.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// Gathers every output file of `slamfuse run` (DESIGN section 5) in the folder; the caller publishes them. A module
/// that did not run gets no file. Errors (kFailed): e.g. disk full.
common::Result<void> write_run_files(const RunSummary& summary, OutputFolder& folder);

/// How every trajectory file of ours begins.
inline const std::string kTrajectoryFileStart = "# slamfuse";

/// A trajectory file: TUM text under a comment line with version and seed, "incomplete" added where it is so.
std::string trajectory_file(const common::Trajectory2& trajectory, std::uint64_t seed, bool incomplete = false);

/// status.csv: `stamp_ns,source,state,score,reasons`; reasons are separated by "; ", quotes and commas inside them
/// give way to ' and ;.
std::string status_csv(const std::vector<fusion::StatusEntry>& status);

}  // namespace slamfuse::service
