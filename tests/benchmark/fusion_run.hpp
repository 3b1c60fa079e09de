// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "benchmark/faulty_recording.hpp"
#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/similarity2.hpp"
#include "common/trajectory_evaluation.hpp"
#include "service/run_request.hpp"
#include "service/run_summary.hpp"

namespace slamfuse {

/// A run of the whole pipeline, as `slamfuse run` makes it, on a recording that may be changed first.
struct FusionRun {
  service::RunRequest request;
  std::optional<SensorFault> fault;
  std::filesystem::path donor;                  ///< of a fault of kind kReplaced
  std::optional<common::Nanoseconds> cut_from;  ///< with cut_to: this time is taken out of the recording
  std::optional<common::Nanoseconds> cut_to;
};

common::Result<service::RunSummary> run(const FusionRun& run);

/// The trajectory of a run by its name in the output; empty if there is none.
common::Trajectory2 trajectory_of(const service::RunSummary& summary, const std::string& name);
/// Root mean square of the position errors [m], fitted as `slamfuse run` does; NaN without.
double ate_of(const service::RunSummary& summary, const std::string& name);

/// The part of a trajectory with from <= stamp < to.
common::Trajectory2 between(const common::Trajectory2& trajectory, common::Nanoseconds from, common::Nanoseconds to);

/// The errors of an estimate under a given transform; of poses without truth there are none.
std::vector<common::PoseError> errors_under(const common::Similarity2& T_truth_map, const common::Trajectory2& estimate,
                                            const common::Trajectory2& truth);
/// The transform from the map's frame to the truth's that fits an estimate best; an error names what is missing.
common::Result<common::Similarity2> fit_to_truth(const common::Trajectory2& estimate, const common::Trajectory2& truth);

/// A pose within 0.5 m and 10 degrees of the truth.
bool is_right(const common::PoseError& error);

}  // namespace slamfuse
