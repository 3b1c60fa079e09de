// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

namespace slamfuse::laser_slam {

/// The heading [rad, in (-pi/2, pi/2], map frame] along which a scan leaves the position open: the weak eigenvector of
/// the position's information with the heading marginalised out (Schur complement), when its eigenvalue is below
/// `ratio` times the strong one. Nothing when the position is held in all directions. `information` is that of (x, y,
/// theta).
std::optional<double> degenerate_direction(const Eigen::Matrix3d& information, double ratio);

}  // namespace slamfuse::laser_slam
