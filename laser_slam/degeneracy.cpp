// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/degeneracy.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace slamfuse::laser_slam {

std::optional<double> degenerate_direction(const Eigen::Matrix3d& information, double ratio) {
  Eigen::Matrix2d position = information.topLeftCorner<2, 2>();
  if (information(2, 2) > 0.0) {
    const Eigen::Vector2d coupling = information.topRightCorner<2, 1>();
    position -= coupling * coupling.transpose() / information(2, 2);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(position);  // eigenvalues rise
  if (eigen.eigenvalues()(0) > ratio * eigen.eigenvalues()(1)) return std::nullopt;
  const Eigen::Vector2d weak = eigen.eigenvectors().col(0);
  if (weak.x() == 0.0) return std::numbers::pi / 2.0;
  return std::atan(weak.y() / weak.x());
}

}  // namespace slamfuse::laser_slam
