// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "common/command.hpp"
#include "common/pose2.hpp"
#include "common/pose_estimate.hpp"
#include "service/merge_window.hpp"

namespace slamfuse::service {

/// The way of commands from the fusion back into the modules, independent of thread timing (DESIGN section 3).
///
/// A command issued while the fusion handles input i takes effect in its module just before that module's first input
/// with index >= i + delay. To make that possible a module waits before input j until the fusion has handled every
/// input up to j - delay.
class CommandPath {
 public:
  /// `delay` in messages, at least 1.
  explicit CommandPath(SequenceIndex delay) : delay_(delay) {}

  /// Fusion, while handling `step`: a command for `target`.
  void issue(const MergedStep& step, common::PoseSource target, const common::Command& command);
  /// Fusion: input `index` and all before it are handled; live, some before it may still be on their way, whose
  /// commands then take effect a little later.
  void advance(SequenceIndex index);

  /// Module `target`, before it processes `input`: waits as said above and returns the commands now due, oldest first.
  /// A SetPose has been carried on by the wheel odometry driven since it was issued, as the robot kept moving
  /// meanwhile. Empty after abort().
  std::optional<std::vector<common::Command>> await(common::PoseSource target, const NumberedMessage& input);

  void abort();

 private:
  struct Issued {
    SequenceIndex due = 0;
    std::optional<common::Pose2> T_odom_base;
    common::Command command;
  };

  const SequenceIndex delay_;
  std::mutex mutex_;
  std::condition_variable advanced_;
  std::map<common::PoseSource, std::deque<Issued>> waiting_;
  SequenceIndex handled_ = -1;
  bool aborted_ = false;
};

}  // namespace slamfuse::service
