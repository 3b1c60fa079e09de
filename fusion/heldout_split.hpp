// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace slamfuse::fusion {

/// Holds every fourth block of neighbouring items out of a fit, so that it can be tested on what it has not seen.
/// Blocks and not single items, because neighbouring poses share their errors.
class HeldoutSplit {
 public:
  /// For `count` items in order of time in blocks of `block` (fewer where that would leave fewer than two held-out
  /// blocks).
  HeldoutSplit(std::size_t count, int block)
      : count_(count), block_(std::clamp<std::size_t>(count / kPeriod / 2, 1, static_cast<std::size_t>(block))) {}

  bool held_out(std::size_t index) const { return (index / block_) % kPeriod == kPeriod - 1; }

  /// The items that are not held out.
  template <class Item>
  std::vector<Item> training(const std::vector<Item>& items) const {
    return select(items, false);
  }
  /// The items that are.
  template <class Item>
  std::vector<Item> test(const std::vector<Item>& items) const {
    return select(items, true);
  }

 private:
  static constexpr std::size_t kPeriod = 4;

  template <class Item>
  std::vector<Item> select(const std::vector<Item>& items, bool wanted) const {
    std::vector<Item> selected;
    for (std::size_t i = 0; i < std::min(count_, items.size()); ++i) {
      if (held_out(i) == wanted) selected.push_back(items[i]);
    }
    return selected;
  }

  std::size_t count_;
  std::size_t block_;
};

}  // namespace slamfuse::fusion
