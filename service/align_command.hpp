// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/error.hpp"
#include "fusion/alignment_options.hpp"

namespace slamfuse::service {

/// What `slamfuse align` was asked for.
struct AlignRequest {
  std::filesystem::path laser;
  std::filesystem::path visual;
  std::filesystem::path out;
  std::uint64_t seed = 1;
  fusion::AlignmentOptions options;
};

/// Aligns two trajectory files of any two SLAM systems and writes metrics.json, visual_aligned.tum and
/// trajectories.svg. Gives the outcome in words. A refused alignment is a result, too: it is written, with the reason,
/// without visual_aligned.tum, and ends as kFailed. Other errors: unreadable input (kInvalidInput), unwritable output.
common::Result<std::string> run_align(const AlignRequest& request);

}  // namespace slamfuse::service
