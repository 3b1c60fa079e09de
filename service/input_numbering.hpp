// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "service/merge_window.hpp"

namespace slamfuse::service {

/// One item of a recording with its place in arrival order.
struct NumberedInput {
  MergedStep step;                                 ///< still without outputs
  std::shared_ptr<const NumberedMessage> message;  ///< nothing for a rejected item
};

/// Numbers what a recording delivers, rejected messages included, and keeps track of the newest wheel odometry.
class InputNumbering {
 public:
  explicit InputNumbering(common::Recording& recording) : recording_(recording) {}

  /// The next input; empty at the end of the recording.
  common::Result<std::optional<NumberedInput>> next();

 private:
  common::Recording& recording_;
  SequenceIndex next_index_ = 0;
  std::optional<common::Pose2> T_odom_base_;
};

}  // namespace slamfuse::service
