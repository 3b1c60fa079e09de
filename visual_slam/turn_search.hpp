// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "visual_slam/camera.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Finds how much further than predicted the robot has turned between two pictures of a camera.
///
/// Without wheel odometry a turn that begins or ends moves all features by up to 100 px together, too far for
/// Lucas-Kanade. So, before they are followed, one number is searched for: the turn about the vertical at which small
/// pictures of all expected features agree best with the new picture. This is not in the seeds, whose cameras run at
/// 15 to 30 Hz. It only says where to start looking; the filter gets what Lucas-Kanade finds.
class TurnSearch {
 public:
  TurnSearch(const TurnSearchOptions& options, std::size_t cameras) : options_(options), previous_(cameras) {}

  /// Takes the next picture of a camera; `expected` are features of the one before. Returns the extra turn [rad],
  /// positive to the left; 0 when there is nothing to go by.
  double find(std::size_t index, const Camera& camera, const cv::Mat& picture,
              std::span<const ExpectedFeature> expected);

 private:
  TurnSearchOptions options_;
  std::vector<cv::Mat> previous_;  // small pictures, by camera
};

/// Where a far feature at `pixel` appears after base_link has turned by `turn` [rad]; empty outside the lens's field.
std::optional<Eigen::Vector2d> turned_pixel(const Camera& camera, const Eigen::Vector2d& pixel, double turn);

}  // namespace slamfuse::visual_slam
