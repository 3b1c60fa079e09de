// SPDX-License-Identifier: BSD-3-Clause
#include "service/grid_png.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <opencv2/imgcodecs.hpp>

namespace slamfuse::service {
namespace {

struct CellRange {
  int left;
  int right;  // past the end
  int bottom;
  int top;  // past the end
};

std::optional<CellRange> known_cells(const common::OccupancyGrid& grid) {
  CellRange range{grid.width, 0, grid.height, 0};
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      if (grid.at(column, row) == common::OccupancyGrid::kUnknown) continue;
      range.left = std::min(range.left, column);
      range.right = std::max(range.right, column + 1);
      range.bottom = std::min(range.bottom, row);
      range.top = std::max(range.top, row + 1);
    }
  }
  if (range.left >= range.right) return std::nullopt;
  return range;
}

// The most occupied of a block of cells; unknown (-1) is below every known value.
std::int8_t block_maximum(const common::OccupancyGrid& grid, int column, int row, int factor) {
  std::int8_t value = common::OccupancyGrid::kUnknown;
  for (int r = row; r < std::min(row + factor, grid.height); ++r) {
    for (int c = column; c < std::min(column + factor, grid.width); ++c) value = std::max(value, grid.at(c, r));
  }
  return value;
}

cv::Vec4b colour_of(std::int8_t occupancy) {
  if (occupancy < 0) return {0, 0, 0, 0};
  const auto gray = static_cast<std::uint8_t>(255 - std::min<int>(occupancy, 100) * 255 / 100);
  return {gray, gray, gray, 255};
}

}  // namespace

std::optional<GridPng> grid_to_png(const common::OccupancyGrid& grid, int max_side) {
  const auto range = known_cells(grid);
  if (!range) return std::nullopt;
  const int width = range->right - range->left;
  const int height = range->top - range->bottom;
  const int factor = (std::max(width, height) + max_side - 1) / max_side;
  const int columns = (width + factor - 1) / factor;
  const int rows = (height + factor - 1) / factor;
  cv::Mat4b image(rows, columns);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      image(rows - 1 - row, column) =
          colour_of(block_maximum(grid, range->left + column * factor, range->bottom + row * factor, factor));
    }
  }
  std::vector<std::uint8_t> png;
  cv::imencode(".png", image, png);
  GridPng picture;
  picture.base64 = to_base64({reinterpret_cast<const char*>(png.data()), png.size()});
  picture.x_min = grid.origin.x() + range->left * grid.resolution;
  picture.x_max = picture.x_min + columns * factor * grid.resolution;
  picture.y_min = grid.origin.y() + range->bottom * grid.resolution;
  picture.y_max = picture.y_min + rows * factor * grid.resolution;
  return picture;
}

std::string to_base64(std::string_view bytes) {
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8U) | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kAlphabet[(group >> (18U - 6U * k)) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace slamfuse::service
