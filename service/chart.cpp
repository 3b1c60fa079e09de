// SPDX-License-Identifier: BSD-3-Clause
#include "service/chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "service/svg.hpp"

namespace slamfuse::service {
namespace {

constexpr std::size_t kMaxPoints = 2000;  // of a series: more than a screen has pixels, little enough for the file
constexpr double kMarginLeft = 52.0;
constexpr double kMarginRight = 14.0;
constexpr double kMarginBottom = 38.0;
constexpr double kTitleBaseline = 16.0;
constexpr double kHeadroom = 1.05;  // the largest value stays below the upper edge
constexpr double kRowHeight = 20.0;
constexpr double kRowGap = 8.0;

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

bool is_drawable(const Eigen::Vector2d& point) { return std::isfinite(point.x()) && std::isfinite(point.y()); }

PlotAxis x_axis(const ChartFrame& frame, const Extent& extent, const PlotArea& area) {
  PlotAxis axis{extent.low, extent.high, area.left, area.right};
  if (frame.x_max > frame.x_min) {
    axis.low = frame.x_min;
    axis.high = frame.x_max;
  } else if (!(axis.high > axis.low)) {
    axis.low -= 0.5;
    axis.high += 0.5;
  }
  return axis;
}

PlotAxis y_axis(const Extent& extent, const PlotArea& area) {
  double low = std::min(0.0, extent.low) * kHeadroom;
  double high = std::max(0.0, extent.high) * kHeadroom;
  if (!(high > low)) high = 1.0;  // all zero
  return {low, high, area.bottom, area.top};
}

std::string dots(const ChartSeries& series, const ChartPoints& points, const PlotAxis& x, const PlotAxis& y) {
  std::string d;
  for (const auto& point : points) {
    if (is_drawable(point)) d += fmt::format("M{:.1f} {:.1f}h0", x(point.x()), y(point.y()));
  }
  return fmt::format("<path class=\"dots {}\" d=\"{}\"/>", series.style, d);
}

std::string line(const ChartSeries& series, const ChartPoints& points, const PlotAxis& x, const PlotAxis& y) {
  std::string d;
  bool pen_down = false;
  for (const auto& point : points) {
    const bool drawable = is_drawable(point);
    if (drawable) d += fmt::format("{}{:.1f} {:.1f}", pen_down ? 'L' : 'M', x(point.x()), y(point.y()));
    pen_down = drawable;
  }
  return fmt::format("<path class=\"line {}\" d=\"{}\"/>", series.style, d);
}

std::string heading(const ChartFrame& frame) { return svg_text(4, kTitleBaseline, frame.title, "start", "title"); }

}  // namespace

ChartPoints decimate(const ChartPoints& points, std::size_t max_points) {
  if (points.size() <= max_points) return points;
  const std::size_t stretches = std::max<std::size_t>(max_points / 2, 1);
  ChartPoints kept;
  kept.reserve(2 * stretches);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * points.size() / stretches;
    const std::size_t end = (s + 1) * points.size() / stretches;
    std::size_t low = end;
    std::size_t high = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_drawable(points[i])) continue;
      if (low == end || points[i].y() < points[low].y()) low = i;
      if (high == end || points[i].y() > points[high].y()) high = i;
    }
    if (low == end) {
      kept.push_back(points[begin]);
    } else {
      kept.push_back(points[std::min(low, high)]);
      if (low != high) kept.push_back(points[std::max(low, high)]);
    }
  }
  return kept;
}

std::string line_chart(const ChartFrame& frame, const std::vector<ChartSeries>& series) {
  std::vector<ChartPoints> points;
  std::vector<LegendEntry> entries;
  Extent x_extent;
  Extent y_extent;
  for (const ChartSeries& s : series) {
    points.push_back(decimate(s.points, kMaxPoints));
    Extent own;
    for (const auto& point : points.back()) {
      if (!is_drawable(point)) continue;
      x_extent.include(point.x());
      y_extent.include(point.y());
      own.include(point.y());
    }
    if (!own.empty())
      entries.push_back({s.label, s.style, s.dots ? LegendEntry::Mark::kDot : LegendEntry::Mark::kLine});
  }
  if (entries.empty()) return "";

  const Legend legend = svg_legend(kMarginLeft, kTitleBaseline + kLegendLine, frame.width - kMarginRight, entries);
  const PlotArea area{kMarginLeft, frame.width - kMarginRight, kTitleBaseline + legend.lines * kLegendLine + 8,
                      frame.height - kMarginBottom};
  const PlotAxis x = x_axis(frame, x_extent, area);
  const PlotAxis y = y_axis(y_extent, area);
  std::string svg = svg_start(frame.width, frame.height, frame.title) + heading(frame) + legend.svg +
                    svg_x_axis(area, x, frame.x_label) + svg_y_axis(area, y, frame.y_label);
  for (std::size_t i = 0; i < series.size(); ++i) {
    svg += series[i].dots ? dots(series[i], points[i], x, y) : line(series[i], points[i], x, y);
  }
  return svg + "</svg>";
}

std::string band_chart(const ChartFrame& frame, const std::vector<BandRow>& rows,
                       const std::vector<std::pair<std::string, std::string>>& legend) {
  const bool empty = std::all_of(rows.begin(), rows.end(), [](const BandRow& row) { return row.bands.empty(); });
  if (empty || !(frame.x_max > frame.x_min)) return "";

  std::vector<LegendEntry> entries;
  for (const auto& [label, style] : legend) entries.push_back({label, style, LegendEntry::Mark::kBox});
  const Legend key = svg_legend(kMarginLeft, kTitleBaseline + kLegendLine, frame.width - kMarginRight, entries);
  PlotArea area{kMarginLeft, frame.width - kMarginRight, kTitleBaseline + key.lines * kLegendLine + 8, 0};
  area.bottom = area.top + static_cast<double>(rows.size()) * (kRowHeight + kRowGap);
  const PlotAxis x{frame.x_min, frame.x_max, area.left, area.right};

  std::string svg = svg_start(frame.width, area.bottom + kMarginBottom, frame.title) + heading(frame) + key.svg +
                    svg_x_axis(area, x, frame.x_label);
  double bottom = area.top;
  for (const BandRow& row : rows) {
    bottom += kRowHeight + kRowGap;
    svg += svg_text(area.left - 5, bottom - kRowHeight / 2 + 2, row.label, "end", "tick");
    for (const Band& band : row.bands) {
      const double from = std::clamp(x(band.from), area.left, area.right);
      const double to = std::clamp(x(band.to), area.left, area.right);
      const double height = kRowHeight * std::clamp(band.height, 0.0, 1.0);
      svg += fmt::format("<rect class=\"band {}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>",
                         band.style, from, bottom - height - 2, std::max(to - from, 0.5), height);
    }
  }
  return svg + "</svg>";
}

std::string chart_style() {
  return R"css(:root{--ink:#1c2127;--soft:#5c6670;--rule:#d9dee3;--ground:#ffffff;--plan:#e6e9ec;
--laser:#0072b2;--visual:#d55e00;--fused:#009e73;--odometry:#8a8f94;--truth:#cc79a7;--landmark:#e69f00;
--tracking:#56b4e9;--uncertain:#e69f00;--lost:#b5310a}
@media(prefers-color-scheme:dark){:root{--ink:#e6e9ec;--soft:#a3adb7;--rule:#3a424a;--ground:#14181d;--plan:#2b3138;
--laser:#56b4e9;--visual:#ff8a3d;--fused:#2fd0a0;--odometry:#9aa2aa;--truth:#e79cc6;--landmark:#f0c14b;
--tracking:#3d8fc0;--uncertain:#e69f00;--lost:#ff6a3d}.plan-grid{filter:invert(1)}}
svg text{font:13px system-ui,sans-serif;fill:var(--ink)}
svg .title{font-weight:600;font-size:14px}
svg .tick,svg .label,svg .key{font-size:12px}
svg .tick,svg .label{fill:var(--soft)}
svg .grid{stroke:var(--rule);stroke-width:1;fill:none}
svg .axis{stroke:var(--soft);stroke-width:1;fill:none}
svg .line{fill:none;stroke-width:1.6;stroke-linejoin:round;stroke-linecap:round}
svg .dots{fill:none;stroke-width:2.6;stroke-linecap:round;stroke-opacity:.7}
svg .dot{stroke:none}
svg .laser{stroke:var(--laser)}svg .visual{stroke:var(--visual)}svg .fused{stroke:var(--fused)}
svg .odometry{stroke:var(--odometry);stroke-dasharray:5 3}svg .truth{stroke:var(--truth)}
svg .landmark{stroke:var(--landmark)}svg .other{stroke:var(--odometry)}
svg .line.laser{stroke-width:2.8;stroke-opacity:.6}
svg .dots.odometry{stroke-dasharray:none}
svg .dot.laser{fill:var(--laser)}svg .dot.visual{fill:var(--visual)}svg .dot.fused{fill:var(--fused)}
svg .dot.odometry{fill:var(--odometry)}svg .dot.truth{fill:var(--truth)}svg .dot.landmark{fill:var(--landmark)}
svg .band{stroke:none}
svg .tracking{fill:var(--tracking)}svg .uncertain{fill:var(--uncertain)}svg .lost{fill:var(--lost)}
svg .plan{fill:var(--plan)}svg .plan-grid{image-rendering:pixelated}
svg .camera{stroke:var(--fused);stroke-width:.7;stroke-opacity:.7;fill:none}svg .line.camera{stroke-width:1.6}
svg .points{stroke-width:1.5;stroke-opacity:1}
svg .ellipse{fill:var(--landmark);fill-opacity:.13;stroke:var(--landmark);stroke-width:.6;stroke-opacity:.6}
svg .rim,svg .feature{fill:none;stroke-linejoin:round}svg .rim{stroke:#000;stroke-width:3.4;stroke-opacity:.6}
svg .feature{stroke-width:1.6}svg .followed{stroke:#56b4e9}svg .recognised{stroke:#ffd400}
svg .rejected{stroke:#ff5a4d}svg .new{stroke:#2fe0a0}
svg .bar{stroke:var(--ink);stroke-width:2;fill:none}
)css";
}

}  // namespace slamfuse::service
