// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"

namespace slamfuse::service {

/// What `slamfuse evaluate` was asked for.
struct EvaluateRequest {
  std::filesystem::path estimate;
  std::optional<std::filesystem::path> reference;  ///< may be missing when there are relations
  common::EvaluationAlignment align = common::EvaluationAlignment::kSe2;
  /// Estimate and reference whose fitted transform is applied instead.
  std::optional<std::pair<std::filesystem::path, std::filesystem::path>> align_as;
  std::optional<std::filesystem::path> relations;
  bool fit_offset = false;                     ///< the reference is of another body by another clock
  common::RecordingOptions recording_options;  ///< of a reference that is a recording
  bool json = false;
};

/// Compares a trajectory with a reference: a trajectory file, a recording with ground truth, or the reference of a
/// corrected CARMEN log (poses of the laser at equal stamps; its mounting comes from the log of the same name beside
/// it, else it is taken to be at base_link). Gives a table, or JSON. Errors (kInvalidInput): unreadable, no truth,
/// nothing in common.
common::Result<std::string> run_evaluate(const EvaluateRequest& request);

}  // namespace slamfuse::service
