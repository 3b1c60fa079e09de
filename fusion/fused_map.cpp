// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/fused_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slamfuse::fusion {
namespace {

std::vector<Eigen::Vector2d> occupied_centres(const common::OccupancyGrid& grid, int occupied) {
  std::vector<Eigen::Vector2d> centres;
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at(column, row) < occupied) continue;
      centres.push_back(grid.origin + grid.resolution * Eigen::Vector2d(column + 0.5, row + 0.5));
    }
  }
  return centres;
}

double distance_to_nearest(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& centres) {
  double square = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& centre : centres) square = std::min(square, (centre - point).squaredNorm());
  return std::sqrt(square);
}

/// The value below which `part` of the sorted values lie.
double quantile(const std::vector<double>& sorted, double part) {
  return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

std::vector<common::Landmark> to_laser_frame(const std::vector<common::Landmark>& landmarks,
                                             const Alignment& alignment) {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Zero();
  linear.topLeftCorner<2, 2>() = alignment.map.linear;
  linear(2, 2) = alignment.mean_scale;
  std::vector<common::Landmark> moved = landmarks;
  for (common::Landmark& landmark : moved) {
    const Eigen::Vector2d ground = landmark.position.head<2>();
    landmark.position.head<2>() = alignment.map * ground;
    landmark.position.z() *= alignment.mean_scale;
    landmark.covariance = linear * landmark.covariance * linear.transpose();
    landmark.covariance.topLeftCorner<2, 2>() += alignment.position_covariance(ground);
  }
  return moved;
}

MapAgreement measure_agreement(const std::vector<common::Landmark>& landmarks, const common::OccupancyGrid& grid,
                               const MapAgreementOptions& options) {
  const std::vector<Eigen::Vector2d> centres = occupied_centres(grid, options.occupied);
  MapAgreement agreement;
  if (centres.empty()) return agreement;
  std::vector<double> distances;
  for (const common::Landmark& landmark : landmarks) {
    const double height = landmark.position.z();
    if (height < options.min_height || height > options.max_height) continue;
    distances.push_back(distance_to_nearest(landmark.position.head<2>(), centres));
  }
  if (distances.empty()) return agreement;
  std::sort(distances.begin(), distances.end());
  agreement.landmarks = distances.size();
  agreement.median_distance = quantile(distances, 0.5);
  agreement.distance_90 = quantile(distances, 0.9);
  return agreement;
}

}  // namespace slamfuse::fusion
