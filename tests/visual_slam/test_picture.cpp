// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/picture.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace slamfuse::visual_slam {
namespace {

common::Image image(int width, int height, std::size_t pixels) {
  common::Image result;
  result.width = width;
  result.height = height;
  result.pixels = std::make_shared<const std::vector<std::uint8_t>>(pixels, std::uint8_t{7});
  return result;
}

TEST(Picture, HasTheSizeOfItsCalibrationAndAllItsPixels) {
  common::CameraCalibration calibration;
  calibration.width = 8;
  calibration.height = 4;

  EXPECT_TRUE(has_size_of(calibration, image(8, 4, 32)));
  EXPECT_FALSE(has_size_of(calibration, image(4, 8, 32)));
  EXPECT_FALSE(has_size_of(calibration, image(8, 4, 31)));
  common::Image without = image(8, 4, 32);
  without.pixels.reset();
  EXPECT_FALSE(has_size_of(calibration, without));
}

TEST(Picture, IsThePixelsThemselves) {
  const common::Image from = image(8, 4, 32);
  const cv::Mat picture = picture_of(from);
  EXPECT_EQ(picture.size(), cv::Size(8, 4));
  EXPECT_EQ(picture.data, from.pixels->data());
}

TEST(Picture, ShowsNothingWhenMoreThanHalfOfItIsSaturated) {
  cv::Mat picture(4, 8, CV_8UC1, cv::Scalar(120));
  EXPECT_TRUE(is_exposed(picture));
  picture.rowRange(0, 1).setTo(0);
  picture.rowRange(1, 2).setTo(255);
  EXPECT_TRUE(is_exposed(picture));
  picture.at<std::uint8_t>(3, 3) = 254;
  EXPECT_FALSE(is_exposed(picture));
}

}  // namespace
}  // namespace slamfuse::visual_slam
