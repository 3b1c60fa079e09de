// SPDX-License-Identifier: BSD-3-Clause
#include "service/merge_stage.hpp"

#include <chrono>
#include <string>
#include <variant>

#include <fmt/format.h>

#include "fusion/measurement_model.hpp"

namespace slamfuse::service {

using common::PoseSource;

void MergeStage::handle(const MergedStep& step) {
  if (requests_ != nullptr) {
    requests_->serve([&](const PipelineRequest& request) {
      return std::visit([&](const auto& wanted) { return this->carry_out(step, wanted); }, request);
    });
  }
  if (step.rejected) tell_rejected(*step.rejected);
  if (step.dropped_of) observer_.on_dropped(*step.dropped_of);
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
  counters_.updated({input.stamp, elapsed.count()});

  if (output.rejected) {
    ++counters_.rejected;
    tell_rejected({input.stamp, "fusion", *output.rejected});
  }
  tell(step, output);
}

void MergeStage::tell(const MergedStep& step, const fusion::FusionOutput& output) {
  for (const auto& event : output.events) observer_.on_event(event);
  for (const auto& status : output.status) observer_.on_status(status);
  for (const auto& command : output.commands) issue(step, command.target, command.command);
  if (output.pose) {
    ++counters_.poses;
    observer_.on_corrected_pose(*output.pose);
  }
}

PipelineRequests::Answer MergeStage::carry_out(const MergedStep& step, const PlaceRobot& request) {
  issue(step, PoseSource::kLaser, request.at);
  const auto& alignment = fusion_.alignment();
  if (!alignment || !alignment->accepted) return std::string("the laser half is told; the visual map is not aligned");
  const auto visual = fusion::visual_pose({request.at.pose, request.at.covariance}, *alignment);
  issue(step, PoseSource::kVisual, common::SetPose{visual.pose, visual.covariance});
  return std::string("both halves are told");
}

PipelineRequests::Answer MergeStage::carry_out(const MergedStep& step, const SearchMap& /*request*/) {
  issue(step, PoseSource::kLaser, common::Relocalise{});
  return std::string("the laser half searches its whole map");
}

PipelineRequests::Answer MergeStage::carry_out(const MergedStep& step, const AlignNow& /*request*/) {
  tell(step, fusion_.align_now());
  const auto& alignment = fusion_.alignment();
  if (!alignment) return common::failed("there is nothing to align yet");
  if (!alignment->accepted) return common::failed("the alignment was refused: " + alignment->reason);
  return fmt::format("aligned: scale {:.4f}, rotation {:.2f} deg, rmse {:.3f} m over {} pairs", alignment->mean_scale,
                     alignment->rotation_deg, alignment->rmse, alignment->pairs);
}

void MergeStage::issue(const MergedStep& step, PoseSource target, const common::Command& command) {
  commands_.issue(step, target, command);
  observer_.on_command(target, command);
}

void MergeStage::tell_rejected(const common::RejectedMessage& message) {
  if (const auto event = rejections_.add(message)) observer_.on_event(*event);
}

}  // namespace slamfuse::service
