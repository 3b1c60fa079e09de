// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

#include "common/error.hpp"
#include "service/run_request.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// Judges a finished run: the coverage of every module and, where the recording has ground truth, the accuracy of every
/// trajectory, aligned by rotation and translation, those named in `free_scale` (made without wheel odometry) by a
/// scale, too. Without truth coverage refers to the processed time. Called after the run: truth never reaches an
/// estimator.
///
/// Errors (kInvalidInput): ground truth that cannot be read.
common::Result<void> judge(const RunRequest& request, const std::set<std::string>& free_scale, RunSummary& summary);

}  // namespace slamfuse::service
