// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common/error.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// Judges a finished run: the coverage of every module and, where the recording has ground truth, the accuracy of every
/// trajectory (aligned by rotation and translation; all sources have wheel odometry and so a scale of their own).
/// Without truth coverage refers to the processed time. Called after the run: truth never reaches an estimator.
///
/// Errors (kInvalidInput): ground truth that cannot be read.
common::Result<void> judge(const std::filesystem::path& recording, RunSummary& summary);

}  // namespace slamfuse::service
