// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "visual_slam/motion_model.hpp"
#include "visual_slam/state.hpp"

namespace slamfuse::visual_slam {

/// What the state is made to believe when the wheels begin to slip and when they grip again. When they do is said by
/// SlipWatch.
class SlipAdmission {
 public:
  /// Makes the odometry's scale as uncertain as slip makes it, and with it the pose reached by it since the last image
  /// (`by_slip`). The camera then tells by how much the wheels slip, and the odometry corrected by that keeps the map's
  /// scale.
  void begin(State& state, BlockId robot, BlockId parameters, const Slip& by_slip);
  /// Gives the odometry the systematic errors it had before the wheels slipped, also for the way since the last image.
  void end(State& state, BlockId robot, BlockId parameters, const Slip& by_slip) const;

 private:
  Eigen::VectorXd mean_;        // of the motion model's numbers before the wheels slipped
  Eigen::MatrixXd covariance_;  // the same
};

}  // namespace slamfuse::visual_slam
