// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include <utility>
#include <vector>

#include "common/thinned_history.hpp"

namespace slamfuse::service {

/// Keeps what happened one after the other in bounded memory: when there are `most` items every second goes, and from
/// then on only every second is taken, and so on. So the kept ones are even over the whole time, at least `most` / 2,
/// and the newest is always among them.
template <class T>
class ThinnedSeries {
 public:
  static constexpr std::size_t kAll = common::kKeepAll;

  /// `most` >= 2; kAll keeps everything.
  explicit ThinnedSeries(std::size_t most = kAll) : most_(most) {}

  void push(T item) {
    if (newest_is_extra_) items_.pop_back();
    newest_is_extra_ = count_ % stride_ != 0;
    ++count_;
    if (items_.size() >= most_) thin();
    items_.push_back(std::move(item));
  }

  const std::vector<T>& items() const { return items_; }
  /// How many there have been.
  std::size_t count() const { return count_; }

  void clear() { *this = ThinnedSeries(most_); }

 private:
  void thin() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < items_.size(); i += 2) {
      if (kept != i) items_[kept] = std::move(items_[i]);
      ++kept;
    }
    items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(kept), items_.end());
    stride_ *= 2;
    newest_is_extra_ = (count_ - 1) % stride_ != 0;
  }

  std::size_t most_;
  std::vector<T> items_;
  std::size_t count_ = 0;
  std::size_t stride_ = 1;        // every so manieth is kept
  bool newest_is_extra_ = false;  // it is there only because it is the newest
};

}  // namespace slamfuse::service
