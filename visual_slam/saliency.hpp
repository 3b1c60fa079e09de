// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

namespace slamfuse::visual_slam {

/// How much each place of a picture stands out from its surroundings, 0 and up (CV_32F, a sixteenth of the picture's
/// width and height): seed 001 section 2.2.1, the model of Itti, Koch and Niebur (1998) with the channels of CIE
/// L*a*b*.
///
/// `picture` is 8-bit gray, or 8-bit BGR where there is colour; a gray one has the channels lightness and orientation.
/// Over a pyramid, each channel's centre (level c = 2, 3, 4) is compared with its surround (level c + 3, c + 4);
/// orientations are what Gabor filters at 0, 45, 90 and 135 deg answer to the lightness. Each map is brought to 0..1
/// and multiplied by (1 - mean of its other local maxima)^2, so that one peak counts and many alike do not. The maps
/// are added for each kind of channel, weighted so again, and averaged over the kinds. Colour is converted at level 2,
/// where the finest centre is, not before the pyramid. A picture smaller than 64 pixels a side stands out nowhere.
///
/// Split over OpenCV's threads; the result does not depend on how many.
cv::Mat saliency_map(const cv::Mat& picture);

/// Where a picture stands out most: 255 in about the `share` (0..1) of it that does, 0 elsewhere; nowhere in a picture
/// without anything. 8 bit, of the picture's size (seed 001 section 2.2.1's binary mask; a share instead of a threshold
/// leaves about the same room in bright and dim pictures).
cv::Mat salient_region(const cv::Mat& picture, double share);

}  // namespace slamfuse::visual_slam
