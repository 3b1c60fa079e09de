// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "service/command_path.hpp"
#include "service/fusion_stage.hpp"
#include "service/merge_window.hpp"
#include "service/module_counters.hpp"
#include "service/pipeline_observer.hpp"
#include "service/pipeline_requests.hpp"
#include "service/rejection_log.hpp"

namespace slamfuse::service {

/// The end of the pipeline: hands merged steps to the fusion, the fusion's commands to the command path, and everything
/// to the observer. Used from one thread at a time.
class MergeStage {
 public:
  /// Keeps at most `most_kept` update times. `requests` may be missing.
  MergeStage(FusionStage& fusion, CommandPath& commands, PipelineObserver& observer, std::size_t most_kept,
             PipelineRequests* requests)
      : fusion_(fusion), commands_(commands), observer_(observer), requests_(requests) {
    counters_.updates = ThinnedSeries<UpdateTime>(most_kept);
  }

  /// The next step: of a replay in index order, live as they become complete.
  void handle(const MergedStep& step);
  /// After the last step: tells the summary of the rejected messages.
  void finish();

  /// Of the fusion.
  const ModuleCounters& counters() const { return counters_; }

 private:
  template <class Input>
  void fuse(const MergedStep& step, const Input& input);
  void tell(const MergedStep& step, const fusion::FusionOutput& output);
  PipelineRequests::Answer carry_out(const MergedStep& step, const PlaceRobot& request);
  PipelineRequests::Answer carry_out(const MergedStep& step, const SearchMap& request);
  PipelineRequests::Answer carry_out(const MergedStep& step, const AlignNow& request);
  void issue(const MergedStep& step, common::PoseSource target, const common::Command& command);
  void tell_rejected(const common::RejectedMessage& message);

  FusionStage& fusion_;
  CommandPath& commands_;
  PipelineObserver& observer_;
  PipelineRequests* requests_;
  RejectionLog rejections_;
  ModuleCounters counters_;
};

}  // namespace slamfuse::service
