// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/turn_by_way.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>

#include "common/pose2.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr std::size_t kFewestFeatures = 8;
constexpr int kWays = 19;
// The turn is looked for within the largest, then, for the next way, near that of the last [rad] ...
constexpr double kLargestTurn = 0.35;
constexpr double kReach = 0.03;
// ... in steps that get finer, features first being allowed to lie farther off their lines [rad].
constexpr double kCoarseStep = 0.006;
constexpr double kCoarseSigma = 0.004;
constexpr double kMiddleStep = 0.0015;
constexpr double kFineStep = 0.0004;
constexpr double kSigma = 0.0012;

constexpr double kLargestInverseDepth = 3.3;  // [1/m]
constexpr double kWrong = 0.1;                // of the features are not where they were ...
constexpr double kWrongLikelihood = 0.05;     // ... but anywhere near; of one on its line it is 1

/// The directions in which a feature was seen, in the axes of base_link: before, at the stamp; now, when it was exposed
/// so many seconds after the stamp.
struct Sight {
  Eigen::Vector3d before;
  Eigen::Vector3d now;
  double delay;
};

Eigen::Vector3d turned_a_little(const Eigen::Vector3d& v, double angle) {
  return {v.x() - angle * v.y(), v.y() + angle * v.x(), v.z()};
}

std::vector<Sight> sights_of(const Camera& camera, std::span<const FollowedFeature> features, double last_turn_rate) {
  const auto direction = [&camera](const Eigen::Vector2d& pixel) -> Eigen::Vector3d {
    return (camera.R_base_camera * camera.calibration.undistort(pixel).homogeneous()).normalized();
  };
  std::vector<Sight> sights;
  sights.reserve(features.size());
  for (const FollowedFeature& feature : features) {
    const double turned = last_turn_rate * camera.row_delay(feature.before);
    sights.push_back(
        {turned_a_little(direction(feature.before), turned), direction(feature.now), camera.row_delay(feature.now)});
  }
  return sights;
}

double log_likelihood_of(const Camera& camera, std::span<const Sight> sights, double seconds, double way, double turn,
                         double sigma) {
  const common::Pose2 driven = common::exp_se2({way, 0.0, turn});
  const Eigen::Matrix3d R = Eigen::AngleAxisd(driven.theta, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d& centre = camera.t_base_camera;
  const Eigen::Vector3d moved = R.transpose() * (Eigen::Vector3d(driven.x, driven.y, 0.0) - centre) + centre;
  double sum = 0.0;
  for (const Sight& sight : sights) {
    // At inverse depth r it is now seen in direction far - r moved; r is that at which it comes nearest.
    const Eigen::Vector3d far = R.transpose() * sight.before;
    const Eigen::Vector3d now = turned_a_little(sight.now, turn / seconds * sight.delay);
    const Eigen::Vector3d off_far = now.cross(far);
    const Eigen::Vector3d off_way = now.cross(moved);
    const double inverse_depth =
        std::clamp(off_far.dot(off_way) / std::max(off_way.squaredNorm(), 1e-14), 0.0, kLargestInverseDepth);
    const double off = (off_far - inverse_depth * off_way).norm() / ((far - inverse_depth * moved).norm() * sigma);
    sum += std::log((1.0 - kWrong) * std::exp(-0.5 * off * off) + kWrong * kWrongLikelihood);
  }
  return sum;
}

}  // namespace

TurnByWay::TurnByWay(const Camera& camera, std::span<const FollowedFeature> features, const PictureStep& step,
                     double least, double most, double otherwise)
    : least_(least), step_((most - least) / (kWays - 1)) {
  if (features.size() < kFewestFeatures || step.seconds <= 0.0 || most <= least) {
    *this = TurnByWay(otherwise);
    return;
  }
  const std::vector<Sight> sights = sights_of(camera, features, step.last_turn_rate);
  double turn = 0.0;
  double likelihood = 0.0;
  const auto search = [&](double way, double reach, double spacing, double sigma) {
    const double middle = turn;
    likelihood = -std::numeric_limits<double>::infinity();
    const int steps = static_cast<int>(std::lround(reach / spacing));
    for (int i = -steps; i <= steps; ++i) {
      const double tried = middle + i * spacing;
      const double found = log_likelihood_of(camera, sights, step.seconds, way, tried, sigma);
      if (found <= likelihood) continue;
      likelihood = found;
      turn = tried;
    }
  };
  for (int i = 0; i < kWays; ++i) {
    const double way = least_ + i * step_;
    search(way, i == 0 ? kLargestTurn : kReach, kCoarseStep, kCoarseSigma);
    search(way, kCoarseStep, kMiddleStep, kSigma);
    search(way, kMiddleStep, kFineStep, kSigma);
    turns_.push_back(turn);
    likelihoods_.push_back(likelihood);
  }
  const double best = *std::max_element(likelihoods_.begin(), likelihoods_.end());
  for (double& one : likelihoods_) one -= best;
}

TurnByWay::Place TurnByWay::place(double way) const {
  const double at = std::clamp((way - least_) / step_, 0.0, static_cast<double>(turns_.size() - 1));
  const auto i = std::min(static_cast<std::size_t>(at), turns_.size() - 2);
  return {i, at - static_cast<double>(i)};
}

double TurnByWay::operator()(double way) const {
  const auto [i, part] = place(way);
  return (1.0 - part) * turns_[i] + part * turns_[i + 1];
}

double TurnByWay::log_likelihood(double way) const {
  if (likelihoods_.empty()) return 0.0;
  const std::size_t i = place(way).i;
  return std::max(likelihoods_[i], likelihoods_[i + 1]);
}

}  // namespace slamfuse::visual_slam
