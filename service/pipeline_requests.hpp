// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <variant>

#include "common/command.hpp"
#include "common/error.hpp"

namespace slamfuse::service {

/// Both halves are to be at this pose, given in the map frame.
struct PlaceRobot {
  common::SetPose at;
};
/// The laser half is to search its whole map.
struct SearchMap {};
/// The maps are to be aligned with what has been collected.
struct AlignNow {};

using PipelineRequest = std::variant<PlaceRobot, SearchMap, AlignNow>;

/// The way of an operator's requests into a running pipeline, which carries them out between two inputs. Only a live
/// pipeline has one: when a request comes depends on the clock.
class PipelineRequests {
 public:
  using Answer = common::Result<std::string>;

  /// Any thread but the pipeline's: hands a request over and waits for what came of it, in words. Error (kFailed): it
  /// was refused, or nothing was processed for `patience`; then it will not be carried out.
  Answer ask(const PipelineRequest& request, std::chrono::nanoseconds patience);

  /// The pipeline, between two inputs: carries out what was asked.
  void serve(const std::function<Answer(const PipelineRequest&)>& carry_out);

  /// Asks every module for a checkpoint after its next pose.
  void want_checkpoints() { ++checkpoints_wanted_; }
  /// How often that was asked.
  std::uint32_t checkpoints_wanted() const { return checkpoints_wanted_; }

 private:
  struct Waiting {
    const PipelineRequest* request;
    bool taken = false;
    std::optional<Answer> answer;
  };

  std::mutex mutex_;
  std::condition_variable answered_;
  std::list<Waiting*> waiting_;
  std::atomic<bool> any_ = false;
  std::atomic<std::uint32_t> checkpoints_wanted_ = 0;
};

}  // namespace slamfuse::service
