// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "visual_slam/motion_model.hpp"

namespace slamfuse::visual_slam {

/// Planar motion without wheel odometry: the robot keeps its speed and its turn rate but for white accelerations, and
/// does not move sideways (seed 002 section 2.2's constant velocities, with the two a wheeled robot has of the six).
///
/// Its numbers are (g, v, w, l). v is the speed in units of the map a second, w the turn rate [rad/s]. exp(l) is how
/// many units of the map a metre is, needed for the lever arm from base_link to the camera: turning on the spot moves
/// the camera by a known way, so l is observed in turns. The map's unit itself is a choice, made by the inverse depth
/// the first landmarks start with, unless the floor tells metres (FloorReckoning); then l is 0 and known. g, always
/// next to 0, is an error of that choice, which all lengths share: State::correct keeps the filter from becoming
/// certain of it.
class ConstantVelocity : public MotionModel {
 public:
  explicit ConstantVelocity(const ConstantVelocityOptions& options) : options_(options) {}

  BlockId append_parameters(State& state) const override;
  /// The velocities change at the start of the step, the pose moves with the new ones.
  bool predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const override;
  bool is_metric() const override { return false; }
  double lever_scale(const State& state, BlockId parameters) const override;
  std::optional<int> lever_scale_index() const override { return kLeverScale; }
  std::optional<BodyTwist> twist(const State& state, BlockId parameters) const override;
  /// v exp(-l).
  std::optional<MotionNumber> metric_speed(const State& state, BlockId parameters) const override;

 private:
  static constexpr int kSpeed = 1;
  static constexpr int kTurnRate = 2;
  static constexpr int kLeverScale = 3;
  static constexpr int kSize = 4;

  ConstantVelocityOptions options_;
};

}  // namespace slamfuse::visual_slam
