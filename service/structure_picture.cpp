// SPDX-License-Identifier: BSD-3-Clause
#include "service/structure_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "service/svg.hpp"

namespace slamfuse::service {
namespace {

constexpr std::size_t kMaxLandmarks = 2000;
constexpr std::size_t kMaxPathPoints = 2000;
constexpr std::size_t kMaxCameras = 300;
constexpr double kWidest = 540.0;  // of the plot [user units]
constexpr double kHighest = 560.0;
constexpr double kNarrowest = 240.0;
constexpr double kMarginLeft = 48.0;
constexpr double kMarginRight = 14.0;
constexpr double kMarginBottom = 38.0;
constexpr double kTickRoom = 46.0;     // on both axes, so that they get the same steps
constexpr double kBorder = 0.05;       // of the larger side, around everything
constexpr double kMinBorder = 0.2;     // [m]
constexpr double kFarShare = 0.02;     // of the landmarks on either side may lie outside
constexpr double kSigmas = 2.0;        // half axes of an ellipse
constexpr double kPyramid = 11.0;      // length of a camera's pyramid [user units]
constexpr double kPyramidWidth = 0.6;  // half width of its base, by its length
constexpr double kPyramidHeight = 0.45;

/// Which coordinates of the map go to the right and up.
using Plane = Eigen::Matrix<double, 2, 3>;

Plane plane_of(int right, int up) {
  Plane plane = Plane::Zero();
  plane(0, right) = 1.0;
  plane(1, up) = 1.0;
  return plane;
}

std::size_t stride_for(std::size_t count, std::size_t limit) {
  return std::max<std::size_t>(1, (count + limit - 1) / limit);
}

/// The box round the cameras and the path and nearly all landmarks.
Eigen::AlignedBox3d extent_of(const StructureAndMotion& map) {
  Eigen::AlignedBox3d box;
  for (const auto& keyframe : map.keyframes) {
    if (keyframe.T_map_camera.is_finite()) box.extend(keyframe.T_map_camera.translation);
  }
  for (const auto& stamped : map.path) {
    if (stamped.pose.is_finite()) box.extend(Eigen::Vector3d(stamped.pose.x, stamped.pose.y, 0.0));
  }
  std::array<std::vector<double>, 3> coordinates;
  for (const auto& landmark : map.landmarks) {
    if (!landmark.position.allFinite()) continue;
    for (int axis = 0; axis < 3; ++axis) {
      coordinates[static_cast<std::size_t>(axis)].push_back(landmark.position[axis]);
    }
  }
  if (coordinates[0].empty()) return box;
  Eigen::Vector3d low, high;
  for (int axis = 0; axis < 3; ++axis) {
    auto& values = coordinates[static_cast<std::size_t>(axis)];
    std::sort(values.begin(), values.end());
    const auto far = static_cast<std::size_t>(kFarShare * static_cast<double>(values.size()));
    low[axis] = values[far];
    high[axis] = values[values.size() - 1 - far];
  }
  return box.extend(low).extend(high);
}

/// Draws in one plane of the map.
struct Drawing {
  Plane plane;
  PlotAxis right;
  PlotAxis up;
  double units_per_metre;

  Eigen::Vector2d operator()(const Eigen::Vector3d& point) const {
    const Eigen::Vector2d flat = plane * point;
    return {right(flat.x()), up(flat.y())};
  }
};

std::string draw_landmarks(const std::vector<common::Landmark>& landmarks, const Drawing& drawing) {
  std::string ellipses;
  std::string dots;
  const std::size_t stride = stride_for(landmarks.size(), kMaxLandmarks);
  for (std::size_t i = 0; i < landmarks.size(); i += stride) {
    if (!landmarks[i].position.allFinite() || !landmarks[i].covariance.allFinite()) continue;
    const Eigen::Vector2d at = drawing(landmarks[i].position);
    dots += fmt::format("M{:.1f} {:.1f}h0", at.x(), at.y());
    const Eigen::Matrix2d covariance = drawing.plane * landmarks[i].covariance * drawing.plane.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
    const Eigen::Vector2d radii =
        kSigmas * drawing.units_per_metre * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
    const Eigen::Vector2d major = axes.eigenvectors().col(1);
    // The picture's second axis points down, so angles turn the other way.
    const double degrees = -std::atan2(major.y(), major.x()) * 180.0 / M_PI;
    ellipses += fmt::format(
        "<ellipse class=\"ellipse\" transform=\"translate({:.1f} {:.1f}) rotate({:.0f})\" rx=\"{:.1f}\" "
        "ry=\"{:.1f}\"/>",
        at.x(), at.y(), degrees, radii.x(), radii.y());
  }
  return ellipses + fmt::format("<path class=\"dots points landmark\" d=\"{}\"/>", dots);
}

std::string draw_cameras(const std::vector<common::Keyframe>& keyframes, const Drawing& drawing) {
  std::string d;
  const double length = kPyramid / drawing.units_per_metre;
  const std::size_t stride = stride_for(keyframes.size(), kMaxCameras);
  for (std::size_t i = 0; i < keyframes.size(); i += stride) {
    const common::Pose3& T_map_camera = keyframes[i].T_map_camera;
    if (!T_map_camera.is_finite()) continue;
    const Eigen::Vector2d tip = drawing(T_map_camera.translation);
    std::array<Eigen::Vector2d, 4> base;
    constexpr std::array<std::array<double, 2>, 4> kCorners{{{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}}};
    for (std::size_t k = 0; k < base.size(); ++k) {
      base[k] = drawing(T_map_camera * Eigen::Vector3d(kCorners[k][0] * kPyramidWidth * length,
                                                       kCorners[k][1] * kPyramidHeight * length, length));
    }
    for (std::size_t k = 0; k < base.size(); ++k) {
      const Eigen::Vector2d& next = base[(k + 1) % base.size()];
      d += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}L{:.1f} {:.1f}", tip.x(), tip.y(), base[k].x(), base[k].y(),
                       next.x(), next.y());
    }
  }
  return d.empty() ? "" : fmt::format("<path class=\"camera\" d=\"{}\"/>", d);
}

std::string draw_path(const common::Trajectory2& path, const Drawing& drawing) {
  std::string d;
  const std::size_t stride = stride_for(path.size(), kMaxPathPoints);
  for (std::size_t i = 0; i < path.size(); i += stride) {
    if (!path[i].pose.is_finite()) continue;
    const Eigen::Vector2d at = drawing({path[i].pose.x, path[i].pose.y, 0.0});
    d += fmt::format("{}{:.1f} {:.1f}", d.empty() ? 'M' : 'L', at.x(), at.y());
  }
  return d.empty() ? "" : fmt::format("<path class=\"line visual\" d=\"{}\"/>", d);
}

}  // namespace

std::string structure_picture(const StructureAndMotion& map, ViewPoint from) {
  if (map.landmarks.empty() && map.keyframes.empty()) return "";
  const Eigen::AlignedBox3d extent = extent_of(map);
  if (extent.isEmpty()) return "";
  const int right_axis = from == ViewPoint::kAbove || extent.sizes().x() >= extent.sizes().y() ? 0 : 1;
  const int up_axis = from == ViewPoint::kAbove ? 1 : 2;
  const Plane plane = plane_of(right_axis, up_axis);

  const double border = std::max(kBorder * (plane * extent.sizes()).maxCoeff(), kMinBorder);
  Eigen::Vector2d low = (plane * extent.min()).array() - border;
  Eigen::Vector2d high = (plane * extent.max()).array() + border;
  const Eigen::Vector2d size = high - low;
  const double units_per_metre = std::min(kWidest / size.x(), kHighest / size.y());
  const double width = std::max(size.x() * units_per_metre, kNarrowest);
  const double extra = (width / units_per_metre - size.x()) / 2;
  low.x() -= extra;
  high.x() += extra;

  const Legend legend = svg_legend(kMarginLeft, 14, kMarginLeft + width,
                                   {{"path of base_link", "visual", LegendEntry::Mark::kLine},
                                    {"cameras", "camera", LegendEntry::Mark::kLine},
                                    {"landmarks, 2 sigma", "landmark", LegendEntry::Mark::kDot}});
  PlotArea area{kMarginLeft, kMarginLeft + width, legend.lines * kLegendLine + 6, 0};
  area.bottom = area.top + size.y() * units_per_metre;
  const Drawing outer{
      plane, {low.x(), high.x(), area.left, area.right}, {low.y(), high.y(), area.bottom, area.top}, units_per_metre};
  // In a drawing of its own, which cuts off what lies outside.
  const double height = area.bottom - area.top;
  const Drawing inner{plane, {low.x(), high.x(), 0.0, width}, {low.y(), high.y(), height, 0.0}, units_per_metre};

  constexpr std::array<const char*, 3> kAxisLabels{"x [m]", "y [m]", "z [m]"};
  return svg_start(
             area.right + kMarginRight, area.bottom + kMarginBottom,
             from == ViewPoint::kAbove ? "Structure and motion from above" : "Structure and motion from the side") +
         legend.svg + svg_x_axis(area, outer.right, kAxisLabels[static_cast<std::size_t>(right_axis)], kTickRoom) +
         svg_y_axis(area, outer.up, kAxisLabels[static_cast<std::size_t>(up_axis)], kTickRoom) +
         fmt::format("<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">", area.left, area.top, width,
                     height) +
         draw_landmarks(map.landmarks, inner) + draw_cameras(map.keyframes, inner) + draw_path(map.path, inner) +
         "</svg></svg>";
}

}  // namespace slamfuse::service
