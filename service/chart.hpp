// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::service {

/// Points (x, y) of a chart, in drawing order. A y that is NaN breaks the line.
using ChartPoints = std::vector<Eigen::Vector2d>;

/// One line or point cloud of a chart.
struct ChartSeries {
  std::string label;  ///< in the legend, plain text (escaped when drawn)
  std::string style;  ///< CSS class that gives the colour: "laser", "visual", "fused", "odometry", "truth", "other"
  ChartPoints points;
  bool dots = false;  ///< draw dots instead of a line
};

/// Labels and size of a chart.
struct ChartFrame {
  std::string title;
  std::string x_label;  ///< with the unit
  std::string y_label;  ///< with the unit
  double x_min = 0.0;   ///< range of the x axis; when empty (min >= max) that of the points
  double x_max = 0.0;
  int width = 480;  ///< user units of the SVG's viewBox; the page scales it. 480 stays readable on a phone
  int height = 230;
};

/// A stretch of time in one state.
struct Band {
  double from = 0.0;
  double to = 0.0;
  std::string style;    ///< CSS class: "tracking", "uncertain", "lost"
  double height = 1.0;  ///< part of the row it fills, 0..1, so that states differ not only in colour
};

/// One row of a band chart.
struct BandRow {
  std::string label;
  std::vector<Band> bands;
};

/// At most `max_points` (>= 2) of the points, the same for the same input: the smallest and the largest y of each of
/// max_points / 2 stretches of equal length, so that peaks survive. A stretch that is all NaN stays one gap.
ChartPoints decimate(const ChartPoints& points, std::size_t max_points);

/// Line chart as an <svg> element with axes, grid, ticks and legend; the y axis starts at 0 unless a value is negative.
/// Colours come from CSS classes (see chart_style()), so that it follows the page's light or dark theme. Empty text
/// when no series has a finite point. Every series is decimated to 2000 points.
std::string line_chart(const ChartFrame& frame, const std::vector<ChartSeries>& series);

/// Rows of coloured stretches over time, e.g. one row a source, coloured by tracking state; the legend lists
/// `legend` (label, style). `height` and `y_label` of the frame are not used; its x range must be given. Empty text
/// when no row has a stretch.
std::string band_chart(const ChartFrame& frame, const std::vector<BandRow>& rows,
                       const std::vector<std::pair<std::string, std::string>>& legend);

/// CSS rules for the classes used in charts and map pictures, light and dark; colours by Okabe and Ito, told apart by
/// colour-blind readers.
std::string chart_style();

}  // namespace slamfuse::service
