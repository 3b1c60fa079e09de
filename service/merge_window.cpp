// SPDX-License-Identifier: BSD-3-Clause
#include "service/merge_window.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace slamfuse::service {

bool MergeWindow::open(MergedStep step, std::set<common::PoseSource> owed_by) {
  std::unique_lock lock(mutex_);
  room_.wait(lock, [this] { return aborted_ || slots_.size() < capacity_; });
  if (aborted_) return false;
  assert(slots_.empty() || step.index > slots_.rbegin()->first);
  const SequenceIndex index = step.index;
  slots_.emplace_hint(slots_.end(), index, Slot{std::move(step), std::move(owed_by)});
  ready_.notify_one();
  return true;
}

void MergeWindow::complete(SequenceIndex index, common::PoseSource source, ModuleOutput output) {
  const std::lock_guard lock(mutex_);
  if (aborted_) return;
  const auto found = slots_.find(index);
  assert(order_ == MergeOrder::kAsComplete || found != slots_.end());
  if (found == slots_.end() || !found->second.owed_by.contains(source)) return;
  Slot& slot = found->second;
  slot.step.outputs.insert_or_assign(source, std::move(output));
  slot.owed_by.erase(source);
  ready_.notify_one();
}

std::optional<MergedStep> MergeWindow::take() {
  std::unique_lock lock(mutex_);
  auto slot = slots_.end();
  ready_.wait(lock, [&] {
    slot = next_slot();
    return aborted_ || slot != slots_.end() || (slots_.empty() && closed_);
  });
  if (aborted_ || slots_.empty()) return std::nullopt;
  std::optional<MergedStep> step(std::move(slot->second.step));
  slots_.erase(slot);
  room_.notify_one();
  return step;
}

MergeWindow::Slots::iterator MergeWindow::next_slot() {
  const auto complete = [](const auto& slot) { return slot.second.owed_by.empty(); };
  if (order_ == MergeOrder::kAsComplete) return std::find_if(slots_.begin(), slots_.end(), complete);
  return slots_.empty() || !complete(*slots_.begin()) ? slots_.end() : slots_.begin();
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
