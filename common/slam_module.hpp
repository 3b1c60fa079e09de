// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "common/command.hpp"
#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// What one input led to.
struct ProcessResult {
  std::optional<PoseEstimate> estimate;  ///< a new pose, if the input made one
  std::optional<std::string> rejected;   ///< why the input was dropped, if it was; nothing changed then
};

/// The interface the pipeline drives a SLAM half through. Implementations own no threads of their own that outlive a
/// call, are deterministic in the sequence of calls, and are called from one thread at a time.
class SlamModule {
 public:
  virtual ~SlamModule() = default;

  /// Which source its estimates carry.
  virtual PoseSource source() const = 0;

  /// Whether it has a use for messages of this kind and sensor; others need not be delivered. May be
  /// called by another thread while process() runs: it must not depend on what process() changes.
  virtual bool wants(const SensorMessage& message) const = 0;

  /// Takes the next message, in arrival order. Never throws; a bad message is rejected with a reason and the run goes
  /// on.
  virtual ProcessResult process(const SensorMessage& message) = 0;

  /// Carries out a command before the next message.
  virtual void execute(const Command& command) = 0;

  /// The path in the map as it is believed now, one pose per estimate made so far and in that order, stamps as
  /// estimated.
  virtual Trajectory2 final_trajectory() const = 0;
};

}  // namespace slamfuse::common
