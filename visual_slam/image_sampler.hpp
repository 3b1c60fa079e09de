// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/annotated_image.hpp"
#include "common/time.hpp"

namespace slamfuse::visual_slam {

/// Keeps a few of the images with their features, spread evenly over a run of unknown length, for people to look at.
///
/// Of each camera at most 8 images are kept, first one a second; when they are too many every second one goes and the
/// interval doubles. Deterministic, memory bounded.
class ImageSampler {
 public:
  static constexpr std::size_t kMaxImages = 8;  ///< of a camera

  /// Whether the image of this camera and stamp should be kept: ask before taking the trouble to mark its features.
  bool wants(const std::string& camera, common::Nanoseconds stamp) const;
  void keep(common::AnnotatedImage image);
  /// All that are kept, by camera and then by time.
  std::vector<common::AnnotatedImage> images() const;

 private:
  struct Series {
    common::Nanoseconds interval = common::kNanosecondsPerSecond;
    std::vector<common::AnnotatedImage> images;
  };

  std::map<std::string, Series> cameras_;
};

}  // namespace slamfuse::visual_slam
