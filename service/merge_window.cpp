// SPDX-License-Identifier: BSD-3-Clause
#include "service/merge_window.hpp"

#include <cassert>
#include <utility>

namespace slamfuse::service {

bool MergeWindow::open(MergedStep step, std::set<common::PoseSource> owed_by) {
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return aborted_ || slots_.size() < capacity_; });
  if (aborted_) return false;
  assert(step.index == first_index_ + static_cast<SequenceIndex>(slots_.size()));
  slots_.push_back({std::move(step), std::move(owed_by)});
  ready_.notify_one();
  return true;
}

void MergeWindow::complete(SequenceIndex index, common::PoseSource source, ModuleOutput output) {
  const std::lock_guard lock(mutex_);
  if (aborted_) return;
  assert(index >= first_index_ && index < first_index_ + static_cast<SequenceIndex>(slots_.size()));
  Slot& slot = slots_[static_cast<std::size_t>(index - first_index_)];
  slot.step.outputs.insert_or_assign(source, std::move(output));
  slot.owed_by.erase(source);
  ready_.notify_one();
}

std::optional<MergedStep> MergeWindow::take() {
  std::unique_lock lock(mutex_);
  ready_.wait(lock, [this] { return aborted_ || (slots_.empty() ? closed_ : slots_.front().owed_by.empty()); });
  if (aborted_ || slots_.empty()) return std::nullopt;
  std::optional<MergedStep> step(std::move(slots_.front().step));
  slots_.pop_front();
  ++first_index_;
  room_.notify_one();
  return step;
}

void MergeWindow::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  ready_.notify_all();
}

void MergeWindow::abort() {
  const std::lock_guard lock(mutex_);
  aborted_ = true;
  slots_.clear();
  room_.notify_all();
  ready_.notify_all();
}

}  // namespace slamfuse::service
