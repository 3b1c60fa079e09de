// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "common/error.hpp"
#include "common/occupancy_grid.hpp"

namespace slamfuse::service {

/// Whether this is a YAML file with an image and a resolution, as read_nav2_map() takes it.
bool is_nav2_map(const std::filesystem::path& yaml);

/// Reads a map as Nav2's map server does (nav2_map_server, map_io.cpp; ROS 1's map_server gives the same cells): a YAML
/// file with image (PNG, PGM, PPM or JPEG; absolute or relative to the YAML file), resolution [m], origin [x, y, yaw]
/// of the lower left corner, negate (0 or 1, false or true), occupied_thresh and free_thresh, and optionally mode
/// (trinary, the default, scale or raw). All of them must be there, as for Nav2: a guessed threshold would turn unknown
/// cells free. Other keys are passed over.
///
/// A pixel's shade s is the mean of its colours, 0 black to 1 white; it is occupied by o = 1 - s, or s with negate:
///   trinary  100 above occupied_thresh, 0 below free_thresh, else unknown. In an image with transparency s is the mean
///            of colours and opacity, as in Nav2: transparent white is unknown, transparent black occupied.
///   scale    the same, but between the thresholds in proportion 0 to 100; unknown is what is not quite opaque
///   raw      255 s itself where it is 0 to 100, else unknown; negate and thresholds do not matter
///
/// Errors (kInvalidInput, naming file, key, value and what is allowed): a file missing, cut or too large, a key missing
/// or out of range, a turned map (yaw not 0: slamfuse's grids lie along their frame's axes).
common::Result<common::OccupancyGrid> read_nav2_map(const std::filesystem::path& yaml);

}  // namespace slamfuse::service
