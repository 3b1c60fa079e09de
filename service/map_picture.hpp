// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "common/occupancy_grid.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::service {

/// A path in the map frame.
struct PathLayer {
  std::string label;  ///< in the legend, plain text
  std::string style;  ///< CSS class of chart_style(): "laser", "visual", "fused", "odometry", "truth"
  common::Trajectory2 path;
};

/// What lies on a plan view: x to the right, y up.
struct MapPicture {
  const common::OccupancyGrid* grid = nullptr;  ///< may be missing
  std::vector<PathLayer> paths;                 ///< drawn in this order, the first at the bottom
  std::vector<Eigen::Vector2d> landmarks;       ///< [m]
};

/// The plan as an <svg> element with axes in metres, a scale bar and a legend, equal scales on both axes; the grid is a
/// PNG inside it. Empty text when there is nothing to draw. Paths are thinned to 2000 points.
std::string map_picture(const MapPicture& picture);

/// The same as a standalone SVG file with its own style sheet, e.g. two trajectories for `slamfuse align`.
std::string map_picture_file(const MapPicture& picture);

}  // namespace slamfuse::service
