// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_explanation.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kEnoughKnown = 0.2;  // share of the beams that must tell something
constexpr double kOwnReach = 0.15;    // [m] from the laser: cells there may be the robot's own or the pose's error

}  // namespace

double ScanExplanation::agreement(double short_weight) const {
  const int known = explained + in_the_way + contradicted;
  if (known == 0 || known < kEnoughKnown * (known + unmapped)) return 0.0;
  return explained / (explained + contradicted + short_weight * in_the_way + 1e-9);
}

bool passes_wall(const LikelihoodField& field, const Eigen::Vector2d& laser, const Eigen::Vector2d& end) {
  const double length = (end - laser).norm();
  return length > kOwnReach && field.passes_wall(laser + (end - laser) * (kOwnReach / length), end, kBeyondWall);
}

ScanExplanation explain_scan(const LikelihoodField& field, const Eigen::Vector2d& mount,
                             const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose, double tolerance) {
  ScanExplanation result;
  const Eigen::Vector2d laser = pose * mount;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d end = pose * point;
    const LikelihoodField::Code code = field.code_at(end);
    if (passes_wall(field, laser, end)) {
      ++result.contradicted;
    } else if (field.distance_of(code) <= tolerance) {
      ++result.explained;
    } else if (LikelihoodField::is_free(code)) {
      ++result.in_the_way;
    } else {
      ++result.unmapped;
    }
  }
  return result;
}

}  // namespace slamfuse::laser_slam
