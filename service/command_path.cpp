// SPDX-License-Identifier: BSD-3-Clause
#include "service/command_path.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace slamfuse::service {
namespace {

common::Command carried_on(common::Command command, const std::optional<common::Pose2>& T_odom_issued,
                           const std::optional<common::Pose2>& T_odom_now) {
  auto* set_pose = std::get_if<common::SetPose>(&command);
  if (set_pose != nullptr && T_odom_issued && T_odom_now) {
    set_pose->pose = set_pose->pose * (T_odom_issued->inverse() * *T_odom_now);
  }
  return command;
}

}  // namespace

void CommandPath::issue(const MergedStep& step, common::PoseSource target, const common::Command& command) {
  const std::lock_guard lock(mutex_);
  waiting_[target].push_back({step.index + delay_, step.T_odom_base, command});
}

void CommandPath::advance(SequenceIndex index) {
  const std::lock_guard lock(mutex_);
  handled_ = std::max(handled_, index);
  advanced_.notify_all();
}

std::optional<std::vector<common::Command>> CommandPath::await(common::PoseSource target,
                                                               const NumberedMessage& input) {
  std::unique_lock lock(mutex_);
  advanced_.wait(lock, [&] { return aborted_ || handled_ >= input.index - delay_; });
  if (aborted_) return std::nullopt;
  std::vector<common::Command> due;
  for (auto& queue = waiting_[target]; !queue.empty() && queue.front().due <= input.index; queue.pop_front()) {
    due.push_back(carried_on(std::move(queue.front().command), queue.front().T_odom_base, input.T_odom_base));
  }
  return due;
}

void CommandPath::abort() {
  const std::lock_guard lock(mutex_);
  aborted_ = true;
  advanced_.notify_all();
}

}  // namespace slamfuse::service
