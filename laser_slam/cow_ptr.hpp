// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <utility>

namespace slamfuse::laser_slam {

/// A shared value that is copied when it is written to while others share it. One word wide; may be empty.
///
/// Different CowPtr objects that share a value may be used from different threads; one CowPtr may not. (std::shared_ptr
/// does not serve: use_count() == 1 gives no ordering against the last reader that let go.)
template <class T>
class CowPtr {
 public:
  CowPtr() = default;
  CowPtr(const CowPtr& other) : block_(other.block_) {
    if (block_) block_->owners.fetch_add(1, std::memory_order_relaxed);
  }
  CowPtr(CowPtr&& other) noexcept : block_(std::exchange(other.block_, nullptr)) {}
  CowPtr& operator=(CowPtr other) noexcept {
    std::swap(block_, other.block_);
    return *this;
  }
  ~CowPtr() {
    if (block_ && block_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete block_;
  }

  /// The value to read, null when empty.
  const T* get() const { return block_ ? &block_->value : nullptr; }

  /// The value to write: made when empty, copied when shared.
  T& write() {
    if (!block_) {
      block_ = new Block;
    } else if (block_->owners.load(std::memory_order_acquire) != 1) {
      CowPtr copy;
      copy.block_ = new Block;
      copy.block_->value = block_->value;
      std::swap(block_, copy.block_);
    }
    return block_->value;
  }

  /// Whether both hold the same value in memory.
  bool shares_with(const CowPtr& other) const { return block_ && block_ == other.block_; }

 private:
  struct Block {
    T value{};
    std::atomic<int> owners{1};
  };
  Block* block_ = nullptr;
};

}  // namespace slamfuse::laser_slam
