// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "common/keyframe.hpp"
#include "common/landmark.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::service {

/// Structure and motion as the visual SLAM has recovered them, in the visual map's frame.
struct StructureAndMotion {
  std::vector<common::Landmark> landmarks;
  std::vector<common::Keyframe> keyframes;
  common::Trajectory2 path;  ///< of base_link, as known at the end
};

/// From where a structure-and-motion picture is looked at.
enum class ViewPoint {
  kAbove,  ///< x to the right, y up
  kSide,   ///< the longer of x and y to the right, z up
};

/// Camera path, cameras as pyramids and landmarks with their 2-sigma ellipses (the covariance cut down to the plane of
/// the picture) as an <svg> element, equal scales on both axes: the viewer of seed 002 section 3.1. Landmarks far
/// outside (beyond the 2nd and 98th percentile) do not count for the extent and may be cut off. At most 2000 landmarks
/// and path points and 300 cameras are drawn. Empty text when there is neither a landmark nor a keyframe.
std::string structure_picture(const StructureAndMotion& map, ViewPoint from);

}  // namespace slamfuse::service
