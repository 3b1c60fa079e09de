// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "visual_slam/motion_model.hpp"

namespace slamfuse::visual_slam {

/// A camera that moves freely in space, for hand-held cameras and robots that pitch and roll: constant velocity and
/// constant angular velocity but for white accelerations (seed 002 section 2.2). The pose is a kFreePose, so that with
/// the two velocities there are the seed's 13 numbers and an error of 12. They are those of base_link, not of the
/// camera; T_base_camera tells how the camera looks at the start, when base_link stands level at the map's origin.
///
/// Its numbers are (g, v, w, l): v [units of the map a second] and w [rad/s] in the axes of base_link (a robot that
/// turns goes on forward), g and l as for ConstantVelocity. Nothing here feels gravity: the map stays level as far as
/// the landmarks hold it.
class FreeCamera : public MotionModel {
 public:
  explicit FreeCamera(const FreeCameraOptions& options) : options_(options) {}

  BlockId append_robot(State& state) const override;
  BlockId append_parameters(State& state) const override;
  /// The velocities change at the start of the step, the pose moves with the new ones.
  bool predict(State& state, BlockId robot, BlockId parameters, const MotionStep& step) const override;
  bool is_metric() const override { return false; }
  double lever_scale(const State& state, BlockId parameters) const override;
  std::optional<int> lever_scale_index() const override { return kLeverScale; }
  std::optional<BodyTwist> twist(const State& state, BlockId parameters) const override;

 private:
  static constexpr int kVelocity = 1;
  static constexpr int kTurnRate = 4;
  static constexpr int kLeverScale = 7;
  static constexpr int kSize = 8;

  FreeCameraOptions options_;
};

}  // namespace slamfuse::visual_slam
