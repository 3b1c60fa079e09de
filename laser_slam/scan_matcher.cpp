// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_matcher.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr std::array<double, 3> kWidening = {3.0, 2.0, 1.4};  // sigma's factor in the first steps
constexpr double kSmallStep = 5e-4;                           // [m, rad] ends the climb
constexpr double kLargestStep = 0.2;                          // [m, rad] of one step
constexpr double kSurfaceNoise = 0.01;                        // [m] added to a surface's moments
constexpr double kLineRatio = 0.2;                            // moments more elongated than this are a line
constexpr double kWeakPrior = 1e-3;                           // [1/m^2, 1/rad^2] keeps the equations solvable

constexpr int kSearchPoints = 60;    // of the scan used in the coarse search
constexpr int kSearchStepCells = 2;  // grid of the coarse search
constexpr double kTieBreak = 1e-3;
constexpr double kSearchStepAngle = 0.04;  // [rad]: 20 cm at 5 m

/// The surface's normal and how much the position along it counts, from the moments' eigenvalues.
struct Direction {
  Eigen::Vector2d normal;
  double along;
};

Direction direction_of(const Surface& surface) {
  const double xx = surface.xx + kSurfaceNoise * kSurfaceNoise;
  const double yy = surface.yy + kSurfaceNoise * kSurfaceNoise;
  const double half_trace = 0.5 * (xx + yy);
  const double half_difference = 0.5 * (xx - yy);
  const double radius = std::sqrt(half_difference * half_difference + surface.xy * surface.xy);
  const double ratio = (half_trace - radius) / (half_trace + radius);
  const double along = std::clamp((ratio - kLineRatio) / (1.0 - kLineRatio), 0.0, 1.0);
  // Twice the angle of the major axis is atan2(xy, half_difference); the normal is turned by a quarter.
  const double major = 0.5 * std::atan2(surface.xy, half_difference);
  return {{-std::sin(major), std::cos(major)}, along};
}

}  // namespace

ScanFit ScanMatcher::evaluate(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose,
                              double old_before) const {
  return evaluate_with(map, points, pose, options_.sigma, old_before);
}

ScanFit ScanMatcher::evaluate_with(const GridMap& map, const std::vector<Eigen::Vector2d>& points,
                                   const common::Pose2& pose, double sigma, double old_before) const {
  const Eigen::Matrix2d rotation = pose.rotation();
  const double inverse_variance = 1.0 / (sigma * sigma);
  const double floor = options_.outlier_probability;
  const double log_outlier = std::log(floor / (1.0 + floor));
  const double log_unknown = std::log(options_.unknown_likelihood);
  ScanFit fit;
  double inliers = 0.0;
  double old = 0.0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d turned = rotation * point;
    const Eigen::Vector2d end = turned + pose.translation();
    const Surface surface = map.surface_at(end, options_.kernel_cells);
    if (surface.weight == 0.0) {
      const bool known = map.known_at(end);
      fit.log_likelihood += known ? log_outlier : log_unknown;
      fit.known += known ? 1 : 0;
      continue;
    }
    const Direction direction = direction_of(surface);
    const Eigen::Vector2d tangent(direction.normal.y(), -direction.normal.x());
    const Eigen::Vector2d offset = end - surface.mean;
    const double across = direction.normal.dot(offset);
    const double along = tangent.dot(offset);
    const double peak = std::exp(-0.5 * inverse_variance * (across * across + direction.along * along * along));
    const double inlier = peak / (peak + floor);
    fit.log_likelihood += std::log((peak + floor) / (1.0 + floor));
    ++fit.known;
    inliers += inlier;
    fit.mean_last_path += inlier * surface.last_path;
    if (surface.last_path < old_before) old += inlier;

    const Eigen::Vector2d lever(-turned.y(), turned.x());  // d end / d theta
    const Eigen::Vector3d across_by(direction.normal.x(), direction.normal.y(), direction.normal.dot(lever));
    const Eigen::Vector3d along_by(tangent.x(), tangent.y(), tangent.dot(lever));
    const double weight = inlier * inverse_variance;
    fit.gradient -= weight * (across * across_by + direction.along * along * along_by);
    fit.information += weight * (across_by * across_by.transpose() + direction.along * along_by * along_by.transpose());
  }
  if (inliers > 0.0) fit.mean_last_path /= inliers;
  if (fit.known > 0) {
    fit.agreement = inliers / fit.known;
    fit.old_share = old / fit.known;
  }
  return fit;
}

ScanMatch ScanMatcher::match(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& start,
                             const PosePrior& prior, double old_before) const {
  const auto prior_error = [&](const common::Pose2& pose) {
    return Eigen::Vector3d(pose.x - prior.mean.x, pose.y - prior.mean.y,
                           common::angle_difference(pose.theta, prior.mean.theta));
  };
  const auto score = [&](const common::Pose2& pose, const ScanFit& fit) {
    const Eigen::Vector3d error = prior_error(pose);
    return gain_ * fit.log_likelihood - 0.5 * error.dot(prior.information * error);
  };
  common::Pose2 pose = start;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    const auto i = static_cast<std::size_t>(iteration);
    const double widening = i < kWidening.size() ? kWidening[i] : 1.0;
    const ScanFit fit = evaluate_with(map, points, pose, options_.sigma * widening, old_before);
    const Eigen::Matrix3d information =
        gain_ * fit.information + prior.information + kWeakPrior * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d gradient = gain_ * fit.gradient - prior.information * prior_error(pose);
    Eigen::Vector3d step = information.llt().solve(gradient);
    const double size = step.cwiseAbs().maxCoeff();
    if (!(size < HUGE_VAL)) break;
    if (size > kLargestStep) step *= kLargestStep / size;
    pose = {pose.x + step.x(), pose.y + step.y(), common::normalize_angle(pose.theta + step.z())};
    if (widening == 1.0 && size < kSmallStep) break;
  }
  const ScanMatch climbed{pose, evaluate(map, points, pose, old_before)};
  const ScanMatch stayed{start, evaluate(map, points, start, old_before)};
  return score(climbed.pose, climbed.fit) >= score(stayed.pose, stayed.fit) ? climbed : stayed;
}

ScanMatch ScanMatcher::search(const GridMap& map, const std::vector<Eigen::Vector2d>& points,
                              const common::Pose2& center, double old_before) const {
  const double step = kSearchStepCells * map.resolution();
  const int steps = static_cast<int>(std::ceil(options_.search_distance / step));
  const int turns = static_cast<int>(std::ceil(options_.search_angle / kSearchStepAngle));
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kSearchPoints);
  double most = -HUGE_VAL;
  common::Pose2 best = center;
  for (int turn = -turns; turn <= turns; ++turn) {
    const double theta = common::normalize_angle(center.theta + turn * kSearchStepAngle);
    const Eigen::Matrix2d rotation = common::Pose2{0.0, 0.0, theta}.rotation();
    std::vector<Eigen::Vector2d> turned;
    for (std::size_t i = 0; i < points.size(); i += stride)
      turned.push_back(rotation * points[i] + center.translation());
    for (int dx = -steps; dx <= steps; ++dx) {
      for (int dy = -steps; dy <= steps; ++dy) {
        const Eigen::Vector2d shift(dx * step, dy * step);
        const auto met = std::count_if(turned.begin(), turned.end(),
                                       [&](const Eigen::Vector2d& end) { return map.occupied_near(end + shift); });
        // Of equals the nearest: the penalty stays below one endpoint.
        const double score = static_cast<double>(met) - kTieBreak * (std::abs(dx) + std::abs(dy) + std::abs(turn));
        if (score <= most) continue;
        most = score;
        best = {center.x + shift.x(), center.y + shift.y(), theta};
      }
    }
  }
  return match(map, points, best, PosePrior{best, Eigen::Matrix3d::Zero()}, old_before);
}

}  // namespace slamfuse::laser_slam
