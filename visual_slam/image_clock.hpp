// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include <opencv2/core.hpp>

#include "common/sensor_message.hpp"
#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// Finds by how much a camera's stamps are off the wheel odometry's, before and without any map: how far the robot
/// turns from one picture to the next is seen in the pictures alone (the median change of the bearings, whatever the
/// scale and the depths), and the stamps at which the odometry turned as far are the true ones. Offsets of some tenths
/// of a second, e.g. stamps at arrival instead of exposure, put every feature tens of pixels off its prediction in a
/// turn, and a filter that predicts with odometry loses itself before anybody could compare two paths.
///
/// Minimised over the offset d is the mean, without the worst tenth, of | turn_k - (theta(t_k + d) - theta(t_{k-1} +
/// d)) |: on a grid, then finer about its best. The standard deviation follows from the residuals' and from how fast
/// the odometry's turns change with d. Not in the seeds.
class ImageClock {
 public:
  ImageClock(const ImageClockOptions& options, const Camera& camera) : options_(options), camera_(camera) {}

  void add(const common::WheelOdometry& odometry);
  /// Takes the next picture with its stamp as the camera told it. Returns the change of the correction [s] when it is
  /// changed.
  std::optional<double> watch(const cv::Mat& picture, common::Nanoseconds stamp);
  /// What has to be added to the camera's stamps.
  common::Nanoseconds correction() const { return correction_; }

 private:
  struct Heading {
    common::Nanoseconds stamp = 0;
    double theta = 0.0;  ///< not wrapped [rad]
  };
  struct Turn {
    common::Nanoseconds from = 0;
    common::Nanoseconds to = 0;
    double angle = 0.0;  ///< [rad]
  };
  struct Fit {
    double offset = 0.0;   ///< [s]
    double misfit = 0.0;   ///< [rad]
    double sigma = 0.0;    ///< [s]
    double current = 0.0;  ///< the misfit of the correction as it is [rad]
    std::size_t turns = 0;
  };

  std::optional<double> turn_between(const cv::Mat& before, const cv::Mat& after) const;
  std::optional<double> heading_at(common::Nanoseconds stamp) const;
  std::optional<double> odometry_turn(const Turn& turn, double offset) const;
  double misfit(double offset) const;
  std::optional<Fit> fit() const;

  ImageClockOptions options_;
  const Camera& camera_;
  std::deque<Heading> headings_;
  std::deque<Turn> turns_;
  cv::Mat last_picture_;
  common::Nanoseconds last_stamp_ = 0;
  common::Nanoseconds correction_ = 0;
  std::size_t since_fit_ = 0;
  bool settled_ = false;
};

}  // namespace slamfuse::visual_slam
