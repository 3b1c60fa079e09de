// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Reads from the floor how fast the robot drives, in metres: a camera's height above the floor is known.
///
/// Small patches of the lower part of a picture are taken for floor, and looked for in an earlier picture of the same
/// camera where the floor was if the robot has driven this or that way since, its turn being known. Each patch that is
/// found at one way only votes for it. Patches that are no floor vote for ways all over, since what they show is nearer
/// than the floor behind it; so a way many vote for, and no other nearly as many, is the way driven.
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

  /// The last step of base_link, as far as it is known without the floor: it took so many seconds, at this speed
  /// forward [m/s] and turn rate [rad/s].
  void moved(double seconds, double speed, double turn_rate);
  /// Takes the next picture of a camera, after moved(). Empty when there is nothing to compare it with, no floor is
  /// seen, or the floor does not tell.
  std::optional<Reading> read(std::size_t index, const Camera& camera, const cv::Mat& picture,
                              common::Nanoseconds stamp);

 private:
  /// An earlier picture.
  struct Reference {
    cv::Mat picture;  // empty: none
    common::Nanoseconds stamp = 0;
    double turn = 0.0;  // [rad] since then
    double way = 0.0;   // [m]
  };

  /// The last reading.
  struct Told {
    double speed = 0.0;
    common::Nanoseconds stamp = 0;
  };

  /// Whether the robot can have got to this speed since the last reading.
  bool follows(double speed, double seconds, common::Nanoseconds stamp) const;
  std::optional<double> way(const Camera& camera, const cv::Mat& now, const Reference& before, double seconds) const;

  FloorSpeedOptions options_;
  std::vector<Reference> references_;  // by camera
  double speed_ = 0.0;                 // of the last step [m/s], without the floor
  std::optional<Told> told_;
};

}  // namespace slamfuse::visual_slam
