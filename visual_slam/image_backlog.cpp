// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_backlog.hpp"

namespace slamfuse::visual_slam {
namespace {

std::size_t bytes_of(const common::Image& image) { return image.pixels ? image.pixels->size() : 0; }

}  // namespace

void ImageBacklog::add(const common::Image& image) {
  images_.push_back(image);
  bytes_ += bytes_of(image);
  while (bytes_ > most_bytes_) {
    bytes_ -= bytes_of(images_.front());
    images_.pop_front();
  }
}

void ImageBacklog::clear() {
  images_.clear();
  bytes_ = 0;
}

}  // namespace slamfuse::visual_slam
