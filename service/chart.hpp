// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::service {

/// Points (x, y) of a chart, in drawing order. A y that is NaN breaks the line.
using ChartPoints = std::vector<Eigen::Vector2d>;

/// One line or point cloud of a chart.
struct ChartSeries {
  std::string label;  ///< in the legend, plain text (escaped when drawn)
  std::string style;  ///< CSS class that gives the colour: "laser", "visual", "fused", "odometry", "truth", "s0".."s3"
  ChartPoints points;
  bool dots = false;  ///< draw dots instead of a line
};

/// Labels and size of a chart.
struct ChartFrame {
  std::string title;
  std::string x_label;  ///< with the unit
  std::string y_label;  ///< with the unit
  int width = 720;      ///< user units of the SVG's viewBox; the page scales it
  int height = 220;
  bool y_from_zero = true;  ///< the y axis starts at 0 (errors, times, counts)
};

/// A stretch of time in one state.
struct Band {
  double from = 0.0;
  double to = 0.0;
  std::string style;  ///< CSS class: "tracking", "uncertain", "lost"
};

/// One row of a band chart.
struct BandRow {
  std::string label;
  std::vector<Band> bands;
};

/// About `count` evenly spaced round numbers (1, 2 or 5 times a power of ten) inside [low, high]. Empty when the range
/// is empty or not finite.
std::vector<double> nice_ticks(double low, double high, int count);

/// At most about `max_points` of the points, the same for the same input: the smallest and the largest y of each of
/// max_points / 2 stretches of equal length, so that peaks survive. A stretch that is all NaN stays one gap.
ChartPoints decimate(const ChartPoints& points, std::size_t max_points);

/// Line chart as an <svg> element with axes, grid, ticks and legend. Colours come from CSS classes (see chart_style()),
/// so that it follows the page's light or dark theme. Empty text when no series has a finite point. Every series is
/// decimated to 2000 points.
std::string line_chart(const ChartFrame& frame, const std::vector<ChartSeries>& series);

/// Rows of coloured stretches over time, e.g. one row a source, coloured by tracking state. `height` and `y_label` of
/// the frame are not used. Empty text when there are no rows or no stretch.
std::string band_chart(const ChartFrame& frame, const std::vector<BandRow>& rows, double x_min, double x_max);

/// CSS rules for the classes used in charts and map pictures, light and dark; colours by Okabe and Ito, told apart by
/// colour-blind readers.
std::string chart_style();

}  // namespace slamfuse::service
