// SPDX-License-Identifier: BSD-3-Clause
#include "service/merge_stage.hpp"

#include <chrono>

namespace slamfuse::service {

void MergeStage::handle(const MergedStep& step) {
  if (step.rejected) tell_rejected(*step.rejected);
  if (step.odometry) {
    observer_.on_odometry(*step.odometry);
    fuse(step, *step.odometry);
  }
  for (const auto& [source, output] : step.outputs) {
    if (output.rejected) tell_rejected(*output.rejected);
    if (!output.estimate) continue;
    for (const auto& event : output.estimate->events) observer_.on_event(event);
    observer_.on_estimate(*output.estimate);
    fuse(step, *output.estimate);
    if (output.map) observer_.on_map(output.estimate->stamp, output.map);
    if (output.checkpoint) observer_.on_checkpoint(source, output.checkpoint);
  }
  commands_.advance(step.index);
  observer_.on_step(step.stamp);
}

void MergeStage::finish() {
  for (const auto& event : rejections_.summary()) observer_.on_event(event);
}

template <class Input>
void MergeStage::fuse(const MergedStep& step, const Input& input) {
  const auto start = std::chrono::steady_clock::now();
  const fusion::FusionOutput output = fusion_.process(input);
  const std::chrono::duration<double, std::milli> elapsed = std::chrono::steady_clock::now() - start;
  ++counters_.inputs;
  counters_.updates.push_back({input.stamp, elapsed.count()});

  if (output.rejected) {
    ++counters_.rejected;
    tell_rejected({input.stamp, "fusion", *output.rejected});
  }
  for (const auto& event : output.events) observer_.on_event(event);
  for (const auto& status : output.status) observer_.on_status(status);
  for (const auto& command : output.commands) commands_.issue(step, command.target, command.command);
  if (output.pose) {
    ++counters_.poses;
    observer_.on_corrected_pose(*output.pose);
  }
}

void MergeStage::tell_rejected(const common::RejectedMessage& message) {
  if (const auto event = rejections_.add(message)) observer_.on_event(*event);
}

}  // namespace slamfuse::service
