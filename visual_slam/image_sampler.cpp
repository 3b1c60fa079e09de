// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_sampler.hpp"

#include <utility>

namespace slamfuse::visual_slam {

bool ImageSampler::wants(const std::string& camera, common::Nanoseconds stamp) const {
  const auto found = cameras_.find(camera);
  if (found == cameras_.end()) return true;
  return stamp - found->second.images.back().image.stamp >= found->second.interval;
}

void ImageSampler::keep(common::AnnotatedImage image) {
  Series& series = cameras_[image.image.sensor];
  series.images.push_back(std::move(image));
  if (series.images.size() <= kMaxImages) return;
  std::vector<common::AnnotatedImage> thinned;
  for (std::size_t i = 0; i < series.images.size(); i += 2) thinned.push_back(std::move(series.images[i]));
  series.images = std::move(thinned);
  series.interval *= 2;
}

std::vector<common::AnnotatedImage> ImageSampler::images() const {
  std::vector<common::AnnotatedImage> all;
  for (const auto& [camera, series] : cameras_) all.insert(all.end(), series.images.begin(), series.images.end());
  return all;
}

}  // namespace slamfuse::visual_slam
