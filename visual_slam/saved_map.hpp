// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "common/error.hpp"
#include "common/landmark.hpp"

namespace slamfuse::visual_slam {

/// Whether landmarks can serve as a map to find oneself in. Errors (kInvalidInput): a place that is no number, a number
/// that occurs twice, no landmark that could be recognised.
common::Result<void> check_saved_map(const std::vector<common::Landmark>& map);

}  // namespace slamfuse::visual_slam
