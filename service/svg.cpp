// SPDX-License-Identifier: BSD-3-Clause
#include "service/svg.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "service/markup.hpp"

namespace slamfuse::service {
namespace {

// The fonts of readers differ: widths are estimated generously.
constexpr double kCharacterWidth = 7.0;
constexpr double kMarkWidth = 18.0;
constexpr double kEntryGap = 14.0;

int tick_count(double length, double room) { return std::max(2, static_cast<int>(length / room)); }

std::string mark(const LegendEntry& entry, double x, double y) {
  switch (entry.mark) {
    case LegendEntry::Mark::kDot:
      return fmt::format("<circle class=\"dot {}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>", entry.style, x + 7, y - 4);
    case LegendEntry::Mark::kBox:
      return fmt::format("<rect class=\"band {}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"12\" height=\"10\"/>", entry.style,
                         x + 1, y - 9);
    case LegendEntry::Mark::kLine:
      break;
  }
  return fmt::format("<path class=\"line {}\" d=\"M{:.1f} {:.1f}h14\"/>", entry.style, x, y - 4);
}

}  // namespace

std::string svg_start(double width, double height, std::string_view title) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\"><title>{}</title>", width,
      height, escape(title));
}

std::string svg_text(double x, double y, std::string_view text, std::string_view anchor, std::string_view style) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\">{}</text>", x, y, anchor, style,
                     escape(text));
}

std::string svg_x_axis(const PlotArea& area, const PlotAxis& axis, std::string_view label, double tick_room) {
  const auto ticks = nice_ticks(axis.low, axis.high, tick_count(area.right - area.left, tick_room));
  const auto labels = tick_labels(ticks);
  std::string svg;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double x = axis(ticks[i]);
    svg += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>", x, area.top, area.bottom);
    svg += svg_text(x, area.bottom + 15, labels[i], "middle", "tick");
  }
  svg += fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", area.left, area.bottom, area.right);
  return svg + svg_text((area.left + area.right) / 2, area.bottom + 31, label, "middle", "label");
}

std::string svg_y_axis(const PlotArea& area, const PlotAxis& axis, std::string_view label, double tick_room) {
  const auto ticks = nice_ticks(axis.low, axis.high, tick_count(area.bottom - area.top, tick_room));
  const auto labels = tick_labels(ticks);
  std::string svg;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double y = axis(ticks[i]);
    svg += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", area.left, y, area.right);
    svg += svg_text(area.left - 5, y + 4, labels[i], "end", "tick");
  }
  svg += fmt::format("<path class=\"axis\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>", area.left, area.top, area.bottom);
  const double middle = (area.top + area.bottom) / 2;
  return svg + fmt::format(
                   "<text transform=\"translate(12 {:.1f}) rotate(-90)\" text-anchor=\"middle\" "
                   "class=\"label\">{}</text>",
                   middle, escape(label));
}

Legend svg_legend(double x, double y, double right, const std::vector<LegendEntry>& entries) {
  Legend legend;
  double cursor = x;
  for (const LegendEntry& entry : entries) {
    const double width = kMarkWidth + kCharacterWidth * static_cast<double>(entry.label.size());
    if (legend.lines == 0 || cursor + width > right) {
      cursor = x;
      ++legend.lines;
    }
    const double line = y + kLegendLine * (legend.lines - 1);
    legend.svg += mark(entry, cursor, line) + svg_text(cursor + kMarkWidth, line, entry.label, "start", "key");
    cursor += width + kEntryGap;
  }
  return legend;
}

}  // namespace slamfuse::service
