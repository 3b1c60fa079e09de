// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/time.hpp"

namespace slamfuse::common {

/// No limit.
inline constexpr std::size_t kKeepAll = std::numeric_limits<std::size_t>::max();

/// Nothing has to be remembered of an item that goes.
struct ForgetWholly {
  template <class T>
  void operator()(T& /*next*/, const T& /*gone*/) const {}
};

/// Keeps a history of stamped things in bounded memory, in whole blocks of time. When there are `most` items, of the
/// blocks kept so far those with an odd place on the clock go, and from then on only every second block is kept, and
/// so on. Which blocks these are is a matter of the stamps alone: histories of different things, thinned at different
/// moments, keep the same blocks, or one keeps a part of the other's, and within a block they are complete. So items
/// of one can still be found, paired and interpolated in the other. The block that lasts is always there.
///
/// T has a member `stamp`; stamps may step back. `Absorb` is called as absorb(next, gone) for each item that goes,
/// oldest first, with the one that came after it, so that increments can be chained.
///
/// Items that something else hangs on can outlive their block, alone: push() is told which. They come on top of `most`.
template <class T, class Absorb = ForgetWholly>
class ThinnedHistory {
 public:
  /// Long enough for some poses of any sensor, short enough to leave no visible corner out of a path.
  static constexpr Nanoseconds kBlock = 2 * kNanosecondsPerSecond;

  /// `most` >= 2; kKeepAll keeps everything.
  explicit ThinnedHistory(std::size_t most = kKeepAll) : most_(most), room_(most) {}

  void push(T item) {
    push(std::move(item), [](const T& /*old*/) { return false; });
  }

  /// `outlives(old)` tells, whenever `old` would go, whether it must not.
  template <class Outlives>
  void push(T item, Outlives outlives) {
    const auto mortal = [&](std::size_t i) { return !outlives(std::as_const(items_[i])); };
    if (!items_.empty() && block_of(item) != block_of(items_.back())) {
      if (!keeps(block_of(items_.back()))) remove_if([&](std::size_t i) { return i >= lasting_ && mortal(i); }, item);
      lasting_ = items_.size();
    }
    if (items_.size() >= room_) thin(item, mortal);
    items_.push_back(std::move(item));
    ++count_;
  }

  /// Takes away the newest one. There must be one.
  void pop() {
    items_.pop_back();
    lasting_ = std::min(lasting_, items_.size());
  }

  const std::vector<T>& items() const { return items_; }
  /// How many have been pushed.
  std::size_t count() const { return count_; }

  /// The kept ones to be changed; their stamps must stay.
  std::span<T> changeable() { return items_; }

  void clear() { *this = ThinnedHistory(most_); }

 private:
  static constexpr Nanoseconds kWidest = Nanoseconds{1} << 40;  // more than there are blocks in 64 bits

  static Nanoseconds block_of(const T& item) { return item.stamp / kBlock; }
  bool keeps(Nanoseconds block) const { return block % stride_ == 0; }

  /// Makes room for `item`; those that are not `mortal` stay.
  template <class Mortal>
  void thin(T& item, Mortal mortal) {
    const auto sweep = [&] {
      remove_if([&](std::size_t i) { return i < lasting_ && !keeps(block_of(items_[i])) && mortal(i); }, item);
    };
    const std::size_t before = items_.size();
    sweep();  // of what outlived its block and need not any more
    if (before - items_.size() >= most_ / 4) return;
    std::size_t immortal = 0;
    for (std::size_t i = 0; i < items_.size(); ++i) immortal += mortal(i) ? 0 : 1;
    room_ = immortal < kKeepAll - most_ ? most_ + immortal : kKeepAll;
    if (items_.size() < room_) return;

    if (items_.size() - lasting_ > most_ / 2) {
      // A block in which more comes than fits: of it the newer half stays, the others are not to blame.
      const std::size_t begin = lasting_;
      const std::size_t middle = begin + (items_.size() - begin + 1) / 2;
      remove_if([&](std::size_t i) { return i >= begin && i < middle && mortal(i); }, item);
      return;
    }
    while (items_.size() >= room_ && stride_ < kWidest) {
      stride_ *= 2;
      sweep();
    }
    if (items_.size() < room_) return;
    // One block, met again and again by stamps that step back.
    const std::size_t surplus = items_.size() - most_ / 2;
    remove_if([&](std::size_t i) { return i < surplus && mortal(i); }, item);
  }

  /// `item` comes after all there are.
  template <class Goes>
  void remove_if(Goes goes, T& item) {
    std::size_t kept = 0;
    std::size_t lasting = items_.size();
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (goes(i)) {
        Absorb()(i + 1 < items_.size() ? items_[i + 1] : item, items_[i]);
        continue;
      }
      if (i >= lasting_) lasting = std::min(lasting, kept);
      if (kept != i) items_[kept] = std::move(items_[i]);
      ++kept;
    }
    items_.erase(items_.begin() + static_cast<std::ptrdiff_t>(kept), items_.end());
    lasting_ = std::min(lasting, kept);
  }

  std::size_t most_;
  std::size_t room_;  // for so many before the next look: `most_` and those that must not go
  std::vector<T> items_;
  std::size_t lasting_ = 0;  // first item of the block that lasts
  std::size_t count_ = 0;
  Nanoseconds stride_ = 1;  // blocks that are multiples of this are kept
};

}  // namespace slamfuse::common
