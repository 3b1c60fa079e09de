// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/imgproc.hpp>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam::testing {

/// A gray picture full of overlapping rectangles and discs of random size and brightness, no two places alike. The same
/// seed draws the same picture.
inline cv::Mat drawn_picture(const cv::Size& size, unsigned seed, int shapes = 400) {
  Noise noise(seed);
  cv::Mat picture(size, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < shapes; ++i) {
    const int x = static_cast<int>(noise.uniform() * size.width), y = static_cast<int>(noise.uniform() * size.height);
    const int a = 4 + static_cast<int>(noise.uniform() * 26.0), b = 4 + static_cast<int>(noise.uniform() * 26.0);
    const cv::Scalar gray(40.0 + 180.0 * noise.uniform());
    if (i % 3 == 0) {
      cv::circle(picture, {x, y}, a / 2, gray, cv::FILLED, cv::LINE_AA);
    } else {
      cv::rectangle(picture, cv::Rect(x, y, a, b), gray, cv::FILLED);
    }
  }
  cv::GaussianBlur(picture, picture, {}, 0.8);
  return picture;
}

/// The picture seen by a camera that has moved a little: `homography` maps old pixels to new ones.
inline cv::Mat moved_picture(const cv::Mat& picture, const cv::Mat& homography) {
  cv::Mat moved;
  cv::warpPerspective(picture, moved, homography, picture.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return moved;
}

}  // namespace slamfuse::visual_slam::testing
