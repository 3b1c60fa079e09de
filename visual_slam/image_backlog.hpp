// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>

#include "common/sensor_message.hpp"

namespace slamfuse::visual_slam {

/// The latest images of all cameras as they came, kept while it is not certain that their stamps are right: when they
/// turn out wrong the map is made anew from these images instead of from the next ones only.
class ImageBacklog {
 public:
  /// Keeps images whose pixels take at most `most_bytes` together; 0 keeps none.
  explicit ImageBacklog(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// An image with its stamp as its camera told it. The pixels are shared, not copied.
  void add(const common::Image& image);
  void clear();
  /// In the order in which they came.
  const std::deque<common::Image>& images() const { return images_; }

 private:
  std::size_t most_bytes_;
  std::size_t bytes_ = 0;
  std::deque<common::Image> images_;
};

}  // namespace slamfuse::visual_slam
