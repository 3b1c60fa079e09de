// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/picture.hpp"

#include <cstddef>
#include <cstdint>

namespace slamfuse::visual_slam {

bool has_size_of(const common::CameraCalibration& calibration, const common::Image& image) {
  return image.width == calibration.width && image.height == calibration.height && image.pixels &&
         image.pixels->size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

cv::Mat picture_of(const common::Image& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data())};
}

bool is_exposed(const cv::Mat& picture) {
  constexpr double kDark = 2.0, kBright = 253.0;  // [gray]
  cv::Mat inside;
  cv::inRange(picture, cv::Scalar(kDark), cv::Scalar(kBright), inside);
  return 2 * cv::countNonZero(inside) >= picture.rows * picture.cols;
}

}  // namespace slamfuse::visual_slam
