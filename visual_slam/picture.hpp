// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "common/calibration.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::visual_slam {

/// Whether an image has the size its camera's calibration is for, and all its pixels.
bool has_size_of(const common::CameraCalibration& calibration, const common::Image& image);

/// The pixels of an image for OpenCV, not copied: they must outlive the picture and are not to be written to.
cv::Mat picture_of(const common::Image& image);

/// Whether the picture shows anything: at most half of it is black or white to the last step or two. Features at the
/// edges of what is saturated move with the light.
bool is_exposed(const cv::Mat& picture);

}  // namespace slamfuse::visual_slam
