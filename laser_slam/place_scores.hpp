// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "laser_slam/beam_model.hpp"
#include "laser_slam/likelihood_field.hpp"

namespace slamfuse::laser_slam {

/// Scores a scan at every free place of an even grid at once, for one heading: the coarse level of PoseSearch.
///
/// At all places a beam ends the same number of cells away, so that of a row of places it meets every `stride`-th cell
/// of a row of the map. The map is kept sorted that way, one byte a cell, and a beam's share of a row of scores is one
/// sum of two vectors. Log-likelihoods are rounded to 1/255 of their range (coarser for more than 257 beams): integers,
/// whose sum depends on no order.
class PlaceScores {
 public:
  /// Places are `stride` >= 1 cells apart; scans have at most `most_beams` >= 1 beams.
  PlaceScores(const LikelihoodField& field, const BeamModel& model, int stride, int most_beams);

  std::size_t places() const { return places_.size(); }
  /// The centre of a place's cell [m, map frame].
  Eigen::Vector2d position(std::size_t place) const;

  /// Writes a score for every place. `offsets`: (columns, rows) from a place to each beam's end, not more than
  /// `most_beams`.
  void score(const std::vector<std::array<int, 2>>& offsets, std::vector<std::uint16_t>& scores) const;

  /// The sum of log-likelihoods that a score of so many beams stands for.
  double log_likelihood(std::uint16_t score, std::size_t beams) const {
    return static_cast<double>(beams) * worst_ + score * unit_;
  }
  /// How much a beam's log-likelihood is rounded at most.
  double rounding() const { return 0.5 * unit_; }

 private:
  struct Place {
    int column;  // of places
    int row;
  };

  int stride_;
  int first_;    // cell of the first place, column and row
  int columns_;  // of places, and of cells in each plane
  int rows_;
  double resolution_;
  Eigen::Vector2d origin_;
  double worst_ = 0.0;  // log-likelihood of a beam that scores 0
  double unit_ = 0.0;   // log-likelihood of 1
  std::uint8_t outside_ = 0;
  std::vector<Place> places_;                     // the free ones, row by row
  std::vector<std::vector<std::uint8_t>> cells_;  // [row % stride * stride + column % stride][row / stride, column /
                                                  // stride]
};

}  // namespace slamfuse::laser_slam
