// SPDX-License-Identifier: BSD-3-Clause
#include "service/pipeline_requests.hpp"

namespace slamfuse::service {

PipelineRequests::Answer PipelineRequests::ask(const PipelineRequest& request, std::chrono::nanoseconds patience) {
  Waiting waiting{&request, false, std::nullopt};
  std::unique_lock lock(mutex_);
  waiting_.push_back(&waiting);
  any_ = true;
  answered_.wait_for(lock, patience, [&] { return waiting.taken; });
  if (!waiting.taken) {
    waiting_.remove(&waiting);
    return common::failed("no message of the robot was processed meanwhile, so nothing was done");
  }
  answered_.wait(lock, [&] { return waiting.answer.has_value(); });
  return *std::move(waiting.answer);
}

void PipelineRequests::serve(const std::function<Answer(const PipelineRequest&)>& carry_out) {
  if (!any_) return;
  while (true) {
    Waiting* next = nullptr;
    {
      const std::lock_guard lock(mutex_);
      if (waiting_.empty()) {
        any_ = false;
        return;
      }
      next = waiting_.front();
      waiting_.pop_front();
      next->taken = true;
      answered_.notify_all();
    }
    auto answer = carry_out(*next->request);
    const std::lock_guard lock(mutex_);
    next->answer = std::move(answer);
    answered_.notify_all();
  }
}

}  // namespace slamfuse::service
