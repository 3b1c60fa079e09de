// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/place_scores.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slamfuse::laser_slam {
namespace {

/// In blocks of a size the compiler knows, for which it takes vector instructions.
void add_to(std::uint16_t* __restrict sums, const std::uint8_t* __restrict addends, std::size_t count) {
  constexpr std::size_t kBlock = 16;
  std::size_t i = 0;
  for (; i + kBlock <= count; i += kBlock) {
    for (std::size_t k = 0; k < kBlock; ++k) sums[i + k] = static_cast<std::uint16_t>(sums[i + k] + addends[i + k]);
  }
  for (; i < count; ++i) sums[i] = static_cast<std::uint16_t>(sums[i] + addends[i]);
}

int floor_divide(int value, int by) { return value >= 0 ? value / by : -((by - 1 - value) / by); }

}  // namespace

PlaceScores::PlaceScores(const LikelihoodField& field, const BeamModel& model, int stride, int most_beams)
    : stride_(stride),
      first_(stride / 2),
      columns_((field.width() + stride - 1) / stride),
      rows_((field.height() + stride - 1) / stride),
      resolution_(field.resolution()),
      origin_(field.origin()) {
  for (int code = 0; code <= std::numeric_limits<LikelihoodField::Code>::max(); ++code) {
    worst_ = std::min(worst_, static_cast<double>(model.log_likelihood(static_cast<LikelihoodField::Code>(code))));
  }
  const int levels = std::min<int>(std::numeric_limits<std::uint8_t>::max(),
                                   std::numeric_limits<std::uint16_t>::max() / std::max(1, most_beams));
  unit_ = worst_ < 0.0 ? -worst_ / levels : 1.0;
  const auto score_of = [&](LikelihoodField::Code code) {
    return static_cast<std::uint8_t>(std::lround((static_cast<double>(model.log_likelihood(code)) - worst_) / unit_));
  };
  outside_ = score_of(field.code(-1, -1));
  const std::size_t size = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  for (int y = 0; y < stride_; ++y) {
    for (int x = 0; x < stride_; ++x) {
      std::vector<std::uint8_t>& plane = cells_.emplace_back();
      plane.reserve(size);
      for (int row = 0; row < rows_; ++row) {
        for (int column = 0; column < columns_; ++column) {
          plane.push_back(score_of(field.code(column * stride_ + x, row * stride_ + y)));
        }
      }
    }
  }
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      const auto code = field.code(column * stride_ + first_, row * stride_ + first_);
      if (LikelihoodField::is_free(code)) places_.push_back({column, row});
    }
  }
}

Eigen::Vector2d PlaceScores::position(std::size_t place) const {
  const Place& p = places_[place];
  return origin_ + Eigen::Vector2d(p.column * stride_ + first_ + 0.5, p.row * stride_ + first_ + 0.5) * resolution_;
}

void PlaceScores::score(const std::vector<std::array<int, 2>>& offsets, std::vector<std::uint16_t>& scores) const {
  struct Shift {
    const std::uint8_t* plane;
    int columns;
    int rows;
  };
  std::vector<Shift> shifts;
  shifts.reserve(offsets.size());
  for (const auto& [dx, dy] : offsets) {
    const int columns = floor_divide(first_ + dx, stride_);
    const int rows = floor_divide(first_ + dy, stride_);
    const int plane = (first_ + dy - rows * stride_) * stride_ + (first_ + dx - columns * stride_);
    shifts.push_back({cells_[static_cast<std::size_t>(plane)].data(), columns, rows});
  }
  scores.resize(places_.size());
  std::vector<std::uint16_t> sums(static_cast<std::size_t>(columns_));
  for (std::size_t begin = 0; begin < places_.size();) {
    const int row = places_[begin].row;
    std::size_t end = begin;
    while (end < places_.size() && places_[end].row == row) ++end;
    // Only the part of the row in which there are places.
    const int first = places_[begin].column;
    const int last = places_[end - 1].column + 1;
    std::fill(sums.begin() + first, sums.begin() + last, std::uint16_t{0});
    for (const Shift& shift : shifts) {
      const bool inside = row + shift.rows >= 0 && row + shift.rows < rows_;
      const int from = inside ? std::clamp(-shift.columns, first, last) : last;
      const int to = inside ? std::clamp(columns_ - shift.columns, from, last) : last;
      if (outside_ != 0) {
        for (int i = first; i < from; ++i) sums[static_cast<std::size_t>(i)] += outside_;
        for (int i = to; i < last; ++i) sums[static_cast<std::size_t>(i)] += outside_;
      }
      if (to <= from) continue;
      const std::uint8_t* cells = shift.plane + static_cast<std::ptrdiff_t>(row + shift.rows) * columns_;
      add_to(sums.data() + from, cells + (from + shift.columns), static_cast<std::size_t>(to - from));
    }
    for (std::size_t place = begin; place < end; ++place) {
      scores[place] = sums[static_cast<std::size_t>(places_[place].column)];
    }
    begin = end;
  }
}

}  // namespace slamfuse::laser_slam
