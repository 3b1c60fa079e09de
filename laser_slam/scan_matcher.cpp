// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_matcher.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

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

/// What a beam's endpoint meets.
struct Meeting {
  Eigen::Vector2d turned;  // the endpoint, turned into the map's axes, about the robot [m]
  Eigen::Vector2d offset;  // from the surface's mean to the endpoint [m]
  Eigen::Vector2d normal;
  double along;  // how much the position along the surface counts, 0 for a line
  double last_path;
  bool surface;  // false: nothing is near, only `known` and `turned` count
  bool known;
};

/// Sets the normal and `along` from the eigenvalues of the surface's moments.
void set_direction(const Surface& surface, Meeting& meeting) {
  const double xx = surface.xx + kSurfaceNoise * kSurfaceNoise;
  const double yy = surface.yy + kSurfaceNoise * kSurfaceNoise;
  const double half_trace = 0.5 * (xx + yy);
  const double half_difference = 0.5 * (xx - yy);
  const double radius = std::sqrt(half_difference * half_difference + surface.xy * surface.xy);
  const double ratio = (half_trace - radius) / (half_trace + radius);
  meeting.along = std::clamp((ratio - kLineRatio) / (1.0 - kLineRatio), 0.0, 1.0);
  meeting.normal = {0.0, 1.0};
  if (radius == 0.0) return;
  // (half_difference, xy) points at twice the angle of the major axis; halved without trigonometry, by the larger of
  // its cosine and sine. The normal is turned by a quarter.
  const double larger = std::sqrt(0.5 * (1.0 + std::abs(half_difference) / radius));
  const double smaller = 0.5 * surface.xy / (radius * larger);
  meeting.normal = half_difference >= 0.0 ? Eigen::Vector2d(-smaller, larger) : Eigen::Vector2d(-larger, smaller);
}

using Meetings = std::vector<Meeting>;

void meet(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose, int kernel_cells,
          Meetings& meetings) {
  const Eigen::Matrix2d rotation = pose.rotation();
  meetings.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    Meeting& meeting = meetings[i];
    meeting.turned = rotation * points[i];
    const Eigen::Vector2d end = meeting.turned + pose.translation();
    const Surface surface = map.surface_at(end, kernel_cells);
    meeting.surface = surface.weight > 0.0;
    meeting.known = meeting.surface || map.known_at(end);
    if (!meeting.surface) continue;
    meeting.offset = end - surface.mean;
    meeting.last_path = surface.last_path;
    set_direction(surface, meeting);
  }
}

/// The logarithm of a product of numbers in (0, 1], taken once for many of them: logarithms are dear.
class LogProduct {
 public:
  void multiply(double factor) {
    product_ *= factor;
    if (product_ > kSmall) return;
    sum_ += std::log(product_);
    product_ = 1.0;
  }
  double log() const { return sum_ + std::log(product_); }

 private:
  static constexpr double kSmall = 1e-200;  // far enough above the smallest double for one more factor
  double product_ = 1.0;
  double sum_ = 0.0;
};

/// How the scan lies: `sigma` [m] of the likelihood; surfaces last seen before `old_before` [m of path] are old.
ScanFit fit_of(const Meetings& meetings, const ScanMatcherOptions& options, double sigma, double old_before) {
  const double inverse_variance = 1.0 / (sigma * sigma);
  const double floor = options.outlier_probability;
  const double per_perfect = 1.0 / (1.0 + floor);
  LogProduct likelihood;
  ScanFit fit;
  double inliers = 0.0;
  double old = 0.0;
  for (const Meeting& meeting : meetings) {
    fit.known += meeting.known ? 1 : 0;
    if (!meeting.surface) {
      likelihood.multiply(meeting.known ? floor * per_perfect : options.unknown_likelihood);
      continue;
    }
    const Eigen::Vector2d& normal = meeting.normal;
    const Eigen::Vector2d tangent(normal.y(), -normal.x());
    const double across = normal.dot(meeting.offset);
    const double along = tangent.dot(meeting.offset);
    const double peak = std::exp(-0.5 * inverse_variance * (across * across + meeting.along * along * along));
    const double inlier = peak / (peak + floor);
    likelihood.multiply((peak + floor) * per_perfect);
    inliers += inlier;
    fit.mean_last_path += inlier * meeting.last_path;
    if (meeting.last_path < old_before) old += inlier;

    const Eigen::Vector2d lever(-meeting.turned.y(), meeting.turned.x());  // d end / d theta
    const Eigen::Vector3d across_by(normal.x(), normal.y(), normal.dot(lever));
    const double weight = inlier * inverse_variance;
    fit.gradient -= (weight * across) * across_by;
    fit.information.noalias() += (weight * across_by) * across_by.transpose();
    if (meeting.along > 0.0) {
      const Eigen::Vector3d along_by(tangent.x(), tangent.y(), tangent.dot(lever));
      const double along_weight = weight * meeting.along;
      fit.gradient -= (along_weight * along) * along_by;
      fit.information.noalias() += (along_weight * along_by) * along_by.transpose();
    }
  }
  fit.log_likelihood = likelihood.log();
  if (inliers > 0.0) fit.mean_last_path /= inliers;
  if (fit.known > 0) {
    fit.agreement = inliers / fit.known;
    fit.old_share = old / fit.known;
  }
  return fit;
}

}  // namespace

ScanFit ScanMatcher::evaluate(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose,
                              double old_before) const {
  Meetings meetings;
  meet(map, points, pose, options_.kernel_cells, meetings);
  return fit_of(meetings, options_, options_.sigma, old_before);
}

ScanMatch ScanMatcher::match(const GridMap& map, const std::vector<Eigen::Vector2d>& points, const common::Pose2& start,
                             const PosePrior& prior, double old_before) const {
  const auto prior_error = [&](const common::Pose2& pose) {
    return Eigen::Vector3d(pose.x - prior.mean.x, pose.y - prior.mean.y,
                           common::angle_difference(pose.theta, prior.mean.theta));
  };
  const auto score = [&](const ScanMatch& match) {
    const Eigen::Vector3d error = prior_error(match.pose);
    return gain_ * match.fit.log_likelihood - 0.5 * error.dot(prior.information * error);
  };
  Meetings meetings;
  meet(map, points, start, options_.kernel_cells, meetings);
  const ScanMatch stayed{start, fit_of(meetings, options_, options_.sigma, old_before)};
  common::Pose2 pose = start;
  std::optional<ScanFit> at_rest;
  for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
    const auto i = static_cast<std::size_t>(iteration);
    const double widening = i < kWidening.size() ? kWidening[i] : 1.0;
    const ScanFit fit = fit_of(meetings, options_, options_.sigma * widening, old_before);
    const Eigen::Matrix3d information =
        gain_ * fit.information + prior.information + kWeakPrior * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d gradient = gain_ * fit.gradient - prior.information * prior_error(pose);
    Eigen::Vector3d step = information.llt().solve(gradient);
    const double size = step.cwiseAbs().maxCoeff();
    if (!(size < HUGE_VAL)) break;
    if (widening == 1.0 && size < kSmallStep) {
      at_rest = fit;
      break;
    }
    if (size > kLargestStep) step *= kLargestStep / size;
    pose = {pose.x + step.x(), pose.y + step.y(), common::normalize_angle(pose.theta + step.z())};
    meet(map, points, pose, options_.kernel_cells, meetings);
  }
  const ScanMatch climbed{pose, at_rest ? *at_rest : fit_of(meetings, options_, options_.sigma, old_before)};
  return score(climbed) >= score(stayed) ? climbed : stayed;
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
