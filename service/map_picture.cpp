// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "service/chart.hpp"
#include "service/grid_png.hpp"
#include "service/svg.hpp"

namespace slamfuse::service {
namespace {

constexpr int kMaxGridSide = 1600;  // [px] of the PNG
constexpr std::size_t kMaxPathPoints = 2000;
constexpr std::size_t kMaxLandmarks = 4000;
constexpr double kWidest = 540.0;  // of the plan [user units]
constexpr double kHighest = 560.0;
constexpr double kNarrowest = 200.0;  // room for the legend beside very tall plans
constexpr double kMarginLeft = 48.0;
constexpr double kMarginRight = 14.0;
constexpr double kMarginBottom = 38.0;
constexpr double kTickRoom = 46.0;  // on both axes, so that they get the same steps
constexpr double kBorder = 0.04;    // of the larger side, around everything
constexpr double kMinBorder = 0.1;  // [m]

// The smallest box round the grid and the paths; landmarks do not count, a few may lie far off.
Eigen::AlignedBox2d extent_of(const std::optional<GridPng>& png, const std::vector<PathLayer>& paths) {
  Eigen::AlignedBox2d box;
  if (png) {
    box.extend(Eigen::Vector2d(png->x_min, png->y_min));
    box.extend(Eigen::Vector2d(png->x_max, png->y_max));
  }
  for (const PathLayer& layer : paths) {
    for (const auto& stamped : layer.path) {
      if (stamped.pose.is_finite()) box.extend(stamped.pose.translation());
    }
  }
  return box;
}

// Every k-th pose and the last one.
common::Trajectory2 thinned(const common::Trajectory2& path) {
  const std::size_t stride = (path.size() + kMaxPathPoints - 1) / kMaxPathPoints;
  if (stride <= 1) return path;
  common::Trajectory2 kept;
  for (std::size_t i = 0; i < path.size(); i += stride) kept.push_back(path[i]);
  if ((path.size() - 1) % stride != 0) kept.push_back(path.back());
  return kept;
}

std::string draw_grid(const GridPng& png, const PlotArea& area, const PlotAxis& x, const PlotAxis& y) {
  return fmt::format("<rect class=\"plan\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>", area.left,
                     area.top, area.right - area.left, area.bottom - area.top) +
         fmt::format(
             "<image class=\"plan-grid\" x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" "
             "preserveAspectRatio=\"none\" href=\"data:image/png;base64,{}\"/>",
             x(png.x_min), y(png.y_max), x(png.x_max) - x(png.x_min), y(png.y_min) - y(png.y_max), png.base64);
}

std::string draw_path(const PathLayer& layer, const PlotAxis& x, const PlotAxis& y) {
  std::string d;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  for (const auto& stamped : thinned(layer.path)) {
    if (!stamped.pose.is_finite()) continue;
    end = {x(stamped.pose.x), y(stamped.pose.y)};
    d += fmt::format("{}{:.1f} {:.1f}", d.empty() ? 'M' : 'L', end.x(), end.y());
  }
  if (d.empty()) return "";
  return fmt::format(
      "<path class=\"line {0}\" d=\"{1}\"/><circle class=\"dot {0}\" cx=\"{2:.1f}\" cy=\"{3:.1f}\" r=\"4\"/>",
      layer.style, d, end.x(), end.y());
}

std::string draw_landmarks(const std::vector<Eigen::Vector2d>& landmarks, const Eigen::AlignedBox2d& box,
                           const PlotAxis& x, const PlotAxis& y) {
  const std::size_t stride = (landmarks.size() + kMaxLandmarks - 1) / kMaxLandmarks;
  std::string d;
  for (std::size_t i = 0; i < landmarks.size(); i += stride) {
    if (landmarks[i].allFinite() && box.contains(landmarks[i])) {
      d += fmt::format("M{:.1f} {:.1f}h0", x(landmarks[i].x()), y(landmarks[i].y()));
    }
  }
  return d.empty() ? "" : fmt::format("<path class=\"dots landmark\" d=\"{}\"/>", d);
}

// The largest of 1, 2 and 5 times a power of ten that is at most `limit`.
double round_length_below(double limit) {
  const double power = std::pow(10.0, std::floor(std::log10(limit)));
  return limit >= 5 * power ? 5 * power : limit >= 2 * power ? 2 * power : power;
}

// Below the plan at the right, where it hides nothing.
std::string draw_scale_bar(const PlotArea& area, double units_per_metre) {
  const double length = round_length_below((area.right - area.left) / 4.0 / units_per_metre);
  const double left = area.right - length * units_per_metre;
  const double y = area.bottom + 31;
  return fmt::format("<path class=\"bar\" d=\"M{0:.1f} {1:.1f}v5H{2:.1f}v-5\"/>", left, y - 7, area.right) +
         svg_text(left - 6, y, fmt::format("{:g} m", length), "end", "key");
}

std::vector<LegendEntry> legend_of(const MapPicture& picture) {
  std::vector<LegendEntry> entries;
  for (const PathLayer& layer : picture.paths) {
    if (!layer.path.empty()) entries.push_back({layer.label, layer.style});
  }
  if (!picture.landmarks.empty()) entries.push_back({"landmarks", "landmark", LegendEntry::Mark::kDot});
  return entries;
}

}  // namespace

std::string map_picture(const MapPicture& picture) {
  const auto png = picture.grid == nullptr ? std::nullopt : grid_to_png(*picture.grid, kMaxGridSide);
  const Eigen::AlignedBox2d extent = extent_of(png, picture.paths);
  if (extent.isEmpty()) return "";

  const double border = std::max(kBorder * extent.sizes().maxCoeff(), kMinBorder);
  const Eigen::AlignedBox2d box(extent.min().array() - border, extent.max().array() + border);
  const Eigen::Vector2d size = box.sizes();
  const double units_per_metre = std::min(kWidest / size.x(), kHighest / size.y());
  const double plan_width = std::max(size.x() * units_per_metre, kNarrowest);

  const double right = kMarginLeft + plan_width;
  const Legend legend = svg_legend(kMarginLeft, 14, right, legend_of(picture));
  PlotArea area{kMarginLeft, right, legend.lines * kLegendLine + 6, 0};
  area.bottom = area.top + size.y() * units_per_metre;
  const double x_extra = (plan_width / units_per_metre - size.x()) / 2;
  const PlotAxis x{box.min().x() - x_extra, box.max().x() + x_extra, area.left, area.right};
  const PlotAxis y{box.min().y(), box.max().y(), area.bottom, area.top};

  std::string svg = svg_start(area.right + kMarginRight, area.bottom + kMarginBottom, "Plan of the run") + legend.svg;
  if (png) svg += draw_grid(*png, area, x, y);
  // Grid lines would look like walls on a map: only the ticks there.
  const PlotArea x_area{area.left, area.right, png ? area.bottom : area.top, area.bottom};
  const PlotArea y_area{area.left, png ? area.left : area.right, area.top, area.bottom};
  svg += svg_x_axis(x_area, x, "x [m]", kTickRoom);
  svg += svg_y_axis(y_area, y, "y [m]", kTickRoom);
  svg += draw_landmarks(picture.landmarks, box, x, y);
  for (const PathLayer& layer : picture.paths) svg += draw_path(layer, x, y);
  return svg + draw_scale_bar(area, units_per_metre) + "</svg>";
}

std::string map_picture_file(const MapPicture& picture) {
  std::string svg = map_picture(picture);
  const std::size_t after_start_tag = svg.find('>');
  if (after_start_tag == std::string::npos) return svg;
  const std::string background = "<rect width=\"100%\" height=\"100%\" fill=\"var(--ground)\"/>";
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n" +
         svg.insert(after_start_tag + 1, "<style>" + chart_style() + "</style>" + background) + "\n";
}

}  // namespace slamfuse::service
