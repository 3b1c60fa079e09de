// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"
#include "fusion/fusion.hpp"

namespace slamfuse::service {

/// What the pipeline asks of the fusion: fusion::Fusion behind an interface, so that tests can put a fake in its place.
class FusionStage {
 public:
  virtual ~FusionStage() = default;
  virtual fusion::FusionOutput process(const common::WheelOdometry& odometry) = 0;
  virtual fusion::FusionOutput process(const common::PoseEstimate& estimate) = 0;
  virtual fusion::FusionOutput align_now() = 0;
  /// See fusion::Fusion::alignment().
  virtual const std::optional<fusion::Alignment>& alignment() const = 0;
};

}  // namespace slamfuse::service
