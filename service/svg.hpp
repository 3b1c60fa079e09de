// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "service/plot_axis.hpp"

namespace slamfuse::service {

/// Where a plot's area lies in its drawing [user units]; y grows downwards.
struct PlotArea {
  double left = 0.0;
  double right = 0.0;
  double top = 0.0;
  double bottom = 0.0;
};

/// One entry of a legend.
struct LegendEntry {
  std::string label;
  std::string style;
  enum class Mark { kLine, kDot, kBox } mark = Mark::kLine;
};

/// An <svg> start tag with a title for screen readers. Close with "</svg>".
std::string svg_start(double width, double height, std::string_view title);

/// A <text> element; the text is escaped. `anchor` is "start", "middle" or "end".
std::string svg_text(double x, double y, std::string_view text, std::string_view anchor, std::string_view style = "");

/// Room one tick with its label takes along its axis [user units].
inline constexpr double kTickRoomX = 60.0;
inline constexpr double kTickRoomY = 34.0;

/// Grid lines, tick labels and the axis label of a horizontal axis at the bottom of the area, a tick every `tick_room`
/// or so.
std::string svg_x_axis(const PlotArea& area, const PlotAxis& axis, std::string_view label,
                       double tick_room = kTickRoomX);

/// The same for a vertical axis at the left of the area.
std::string svg_y_axis(const PlotArea& area, const PlotAxis& axis, std::string_view label,
                       double tick_room = kTickRoomY);

/// A legend that starts at (x, y) and wraps at `right`.
struct Legend {
  std::string svg;
  int lines = 0;
};
inline constexpr double kLegendLine = 17.0;  ///< height of a line of a legend [user units]
Legend svg_legend(double x, double y, double right, const std::vector<LegendEntry>& entries);

}  // namespace slamfuse::service
