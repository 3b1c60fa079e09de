// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "common/trajectory.hpp"
#include "fusion/planar_affine.hpp"

namespace slamfuse::fusion {

/// Normal and uniform random numbers that are the same with every standard library.
class TestNoise {
 public:
  explicit TestNoise(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return (static_cast<double>(engine_() >> 11U) + 0.5) * 0x1.0p-53; }
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(uniform()));  // drawn first, whatever the compiler
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

 private:
  std::mt19937_64 engine_;
};

inline constexpr common::Nanoseconds kTestStart = 1'700'000'000 * common::kNanosecondsPerSecond;
inline constexpr common::Nanoseconds kTestStep = common::kNanosecondsPerSecond / 10;

/// A bent path through a flat, 10 poses a second: two incommensurate waves, headings along the path.
inline common::Trajectory2 flat_path(std::size_t count = 600) {
  common::Trajectory2 path;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = 0.02 * static_cast<double>(i);
    const double dx = 3.0 * std::cos(t);
    const double dy = 5.0 * 0.61 * std::cos(0.61 * t + 0.4);
    path.push_back({kTestStart + static_cast<common::Nanoseconds>(i) * kTestStep,
                    {3.0 * std::sin(t), 5.0 * std::sin(0.61 * t + 0.4), std::atan2(dy, dx)}});
  }
  return path;
}

/// The visual trajectory that `laser_from_visual` maps onto `laser`, with noise [visual units] and a share of outliers
/// that lie anywhere in the path's surroundings.
inline common::Trajectory2 visual_path(const common::Trajectory2& laser, const PlanarAffine& laser_from_visual,
                                       double noise, double outliers, std::uint64_t seed) {
  TestNoise random(seed);
  const PlanarAffine inverse = laser_from_visual.inverse();
  const double rotation = take_apart(laser_from_visual).rotation;
  common::Trajectory2 visual;
  for (const common::StampedPose2& pose : laser) {
    Eigen::Vector2d position = inverse * pose.pose.translation();
    if (random.uniform() < outliers) {
      position = inverse * Eigen::Vector2d(16.0 * random.uniform() - 8.0, 16.0 * random.uniform() - 8.0);
    }
    position += noise * Eigen::Vector2d(random.normal(), random.normal());
    visual.push_back({pose.stamp, {position.x(), position.y(), common::Pose2{0, 0, pose.pose.theta - rotation}.theta}});
  }
  return visual;
}

/// Turn by `degrees`, with a scale per axis of the visual map, and a shift.
inline PlanarAffine stretched_map(double degrees, double scale_x, double scale_y, double shift_x, double shift_y) {
  const common::Pose2 turn{shift_x, shift_y, degrees * std::numbers::pi / 180.0};
  return {turn.rotation() * Eigen::Vector2d(scale_x, scale_y).asDiagonal(), turn.translation()};
}

}  // namespace slamfuse::fusion
