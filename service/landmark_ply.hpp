// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/landmark.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse::service {

/// The landmarks as a PLY point cloud (ASCII) in their brightness. With an accepted alignment the points are in the
/// laser map's frame (heights scaled by the mean scale), otherwise in the visual map's own; a comment line says which.
/// Each has the number of the known object it is on, 0 for none; comment lines say the names.
std::string landmarks_to_ply(const std::vector<common::Landmark>& landmarks, const fusion::Alignment& alignment);

}  // namespace slamfuse::service
