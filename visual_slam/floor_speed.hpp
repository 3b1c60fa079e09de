// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/turn_by_way.hpp"
#include "visual_slam/way_votes.hpp"

namespace slamfuse::visual_slam {

/// Reads from the floor how fast the robot drives, in metres: a camera's height above the floor is known.
///
/// Small patches of the lower part of a picture are taken for floor, and looked for in an earlier picture of the same
/// camera where the floor was if the robot has driven this or that way since, turning as it must have turned then. Each
/// patch that is found at one way only votes for it (likeliest_way). Patches behind which something is known to stand
/// above the floor do not vote.
///
/// This is not in the seeds, whose camera without odometry leaves the scale free (seed 002 section 2). Landmarks are
/// not used: a floor has few corners that last.
class FloorSpeed {
 public:
  /// A speed of the last step: the mean over the time between two pictures, and what the steps between them say it
  /// changed by since.
  struct Reading {
    double speed = 0.0;    ///< of base_link forward [m/s]
    double seconds = 0.0;  ///< between the pictures
  };

  FloorSpeed(const FloorSpeedOptions& options, std::size_t cameras) : options_(options), references_(cameras) {}

  /// Whether the floor, if there is any, is in a camera's picture, and the camera's height above it known.
  static bool may_see_floor(const Camera& camera);
  /// The ways [m] that are looked for in so many seconds.
  WayRange possible_ways(double seconds) const;
  /// The last step of base_link, as far as it is known without the floor: it took so many seconds, at this speed
  /// forward [m/s], with this turn.
  void moved(double seconds, double speed, const TurnByWay& turn);
  /// Takes the next picture of a camera, after moved(). `standing` are points of base_link [m] that are known to lie
  /// above the floor, on things that stand on it. Empty when there is nothing to compare with, no floor is seen, or the
  /// floor does not tell.
  std::optional<Reading> read(std::size_t index, const Camera& camera, const cv::Mat& picture,
                              common::Nanoseconds stamp, std::span<const Eigen::Vector3d> standing);

 private:
  struct Step {
    double seconds = 0.0;
    TurnByWay turn;
  };

  /// An earlier picture.
  struct Reference {
    cv::Mat picture;  // empty: none
    common::Nanoseconds stamp = 0;
    std::vector<Step> steps;  // since then
    double seconds = 0.0;     // that they took
    double way = 0.0;         // [m]

    /// The turn since then if the robot has driven so far, evenly.
    double turn(double way_driven) const;
  };

  std::optional<double> way(const Camera& camera, const cv::Mat& now, const Reference& before, double seconds,
                            std::span<const Eigen::Vector3d> standing) const;

  FloorSpeedOptions options_;
  std::vector<Reference> references_;  // by camera
  double speed_ = 0.0;                 // of the last step [m/s], without the floor
};

}  // namespace slamfuse::visual_slam
