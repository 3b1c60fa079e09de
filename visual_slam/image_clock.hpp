// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "common/sensor_message.hpp"
#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/turn_search.hpp"

namespace slamfuse::visual_slam {

/// Finds by how much a camera's stamps are off the wheel odometry's, before and without any map: how far the robot
/// turns from one picture to the next is seen in the pictures (the turn for which the rays lie in their epipolar
/// planes, whatever the depths), and the stamps at which the odometry turned as far are the true ones. Offsets of some
/// tenths of a second, e.g. stamps at arrival instead of exposure, put every feature tens of pixels off its prediction
/// in a turn, and a filter that predicts with odometry loses itself before anybody could compare two paths.
///
/// Minimised over the offset d is the mean, without the worst tenth, of | turn_k - k (theta(t_k + d) - theta(t_{k-1} +
/// d)) |, k being the least squares' scale of the odometry's turns, within a tenth of 1: on a grid, then finer about
/// its best. The standard deviation follows from the residuals' and from how fast the odometry's turns change with d.
/// Not in the seeds.
class ImageClock {
 public:
  ImageClock(const ImageClockOptions& options, const TurnSearchOptions& search, const Camera& camera)
      : options_(options), camera_(camera), search_(search, 1), smallest_offset_(options.smallest_offset) {}

  void add(const common::WheelOdometry& odometry);
  /// Takes the next picture with its stamp as the camera told it. Returns the change of the correction [s] when it is
  /// changed.
  std::optional<double> watch(const cv::Mat& picture, common::Nanoseconds stamp);
  /// What has to be added to the camera's stamps.
  common::Nanoseconds correction() const { return found_ ? found_->correction : 0; }
  /// Gives each clock whose correction was found the weighted mean of those that differ from it by less than three
  /// standard deviations: the cameras of a robot mostly share a clock, and an error all have in common does no harm,
  /// while cameras that are a few milliseconds out of step with each other make a map of the wrong size. The clocks of
  /// which none was found are watched more closely from now on, for the same reason.
  static void share(std::vector<ImageClock>& clocks);
  /// Whether it looks for another correction, having seen pictures.
  bool is_watching() const { return may_change() && last_stamp_ != 0; }

 private:
  struct Place {
    common::Nanoseconds stamp = 0;
    double theta = 0.0;                                  ///< by the odometry, not wrapped [rad]
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< by the odometry [m]
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
  struct Correction {
    common::Nanoseconds correction = 0;
    double sigma = 0.0;  ///< [s]
  };

  /// A picture as small as it may be: one of its pixels is `scale` wide in the camera's.
  struct Small {
    cv::Mat picture;
    double scale = 1.0;
  };

  static Small shrunk(const cv::Mat& picture);
  /// From the last picture to this one [rad], in which time the robot drove about `distance` [m].
  std::optional<double> turn_to(const cv::Mat& after, double distance);
  std::optional<Place> place_at(common::Nanoseconds stamp) const;
  double distance(common::Nanoseconds from, common::Nanoseconds to) const;
  std::optional<double> odometry_turn(const Turn& turn, double offset) const;
  /// By how much the pictures' turns miss the odometry's at stamps moved by `offset` [s], each >= 0 [rad].
  std::vector<double> misfits(double offset) const;
  double misfit(double offset) const;
  std::optional<Fit> fit() const;
  bool may_change() const { return options_.correct && !settled_; }

  ImageClockOptions options_;
  const Camera& camera_;
  TurnSearch search_;
  std::deque<Place> places_;
  std::deque<Turn> turns_;
  Small last_;
  common::Nanoseconds last_stamp_ = 0;
  std::optional<Correction> found_;
  double smallest_offset_;  // [s] that is corrected
  std::size_t since_fit_ = 0;
  bool settled_ = false;
};

}  // namespace slamfuse::visual_slam
