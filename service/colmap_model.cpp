// SPDX-License-Identifier: BSD-3-Clause
#include "service/colmap_model.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>

#include <fmt/format.h>

namespace slamfuse::service {
namespace {

constexpr double kPixelCentre = 0.5;  // of the first pixel, in COLMAP's coordinates
constexpr const char* kFrame =
    "# slamfuse visual map, frame visual_map: z up, in metres (where neither wheel odometry nor the floor tells any, "
    "in the map's own unit)\n";

/// What is known of a point while its keyframes are gone through.
struct Point {
  const common::Landmark* landmark = nullptr;
  std::string track;
  double error_sum = 0.0;  // [px]
  int observations = 0;
};

std::string camera_line(int id, const common::CameraCalibration& camera) {
  const std::string pinhole =
      fmt::format("{} {} {} {}", camera.fx, camera.fy, camera.cx + kPixelCentre, camera.cy + kPixelCentre);
  const std::string opencv = fmt::format("{} {} {} {} {}", pinhole, camera.k1, camera.k2, camera.p1, camera.p2);
  const bool distorted = camera.k1 != 0.0 || camera.k2 != 0.0 || camera.p1 != 0.0 || camera.p2 != 0.0;
  const auto line = [&](const char* model, const std::string& parameters) {
    return fmt::format("{} {} {} {} {}\n", id, model, camera.width, camera.height, parameters);
  };
  if (camera.k3 != 0.0) return line("FULL_OPENCV", fmt::format("{} {} 0 0 0", opencv, camera.k3));
  return distorted ? line("OPENCV", opencv) : line("PINHOLE", pinhole);
}

std::string pose_text(const common::Pose3& T_camera_map) {
  const Eigen::Quaterniond& q = T_camera_map.rotation;
  const Eigen::Vector3d& t = T_camera_map.translation;
  return fmt::format("{:.12g} {:.12g} {:.12g} {:.12g} {:.9g} {:.9g} {:.9g}", q.w(), q.x(), q.y(), q.z(), t.x(), t.y(),
                     t.z());
}

std::string point_line(std::int64_t id, const Point& point) {
  const Eigen::Vector3d& position = point.landmark->position;
  const int gray = point.landmark->gray;
  const double error = point.observations > 0 ? point.error_sum / point.observations : -1.0;
  return fmt::format("{} {:.9g} {:.9g} {:.9g} {} {} {} {:.4g}{}\n", id, position.x(), position.y(), position.z(), gray,
                     gray, gray, error, point.track);
}

}  // namespace

ColmapModel colmap_model(const std::map<std::string, common::CameraCalibration>& cameras,
                         const std::vector<common::Keyframe>& keyframes,
                         const std::vector<common::Landmark>& landmarks) {
  std::map<std::string, int> camera_ids;
  for (const common::Keyframe& keyframe : keyframes) {
    if (cameras.contains(keyframe.camera)) camera_ids.emplace(keyframe.camera, 0);
  }
  ColmapModel model;
  model.cameras = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  int next_camera = 1;
  for (auto& [name, id] : camera_ids) {
    id = next_camera++;
    model.cameras += fmt::format("# {} is {}\n{}", id, name, camera_line(id, cameras.at(name)));
  }

  std::map<std::int64_t, Point> points;
  for (const common::Landmark& landmark : landmarks) points[landmark.id].landmark = &landmark;

  model.images = kFrame;
  model.images +=
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME (world to camera)\n"
      "# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  int image_id = 0;
  for (const common::Keyframe& keyframe : keyframes) {
    if (!camera_ids.contains(keyframe.camera)) continue;
    const common::CameraCalibration& camera = cameras.at(keyframe.camera);
    const common::Pose3 T_camera_map = keyframe.T_map_camera.inverse();
    ++image_id;
    std::string seen;
    int index = 0;
    for (const common::KeyframeObservation& observation : keyframe.observations) {
      const auto point = points.find(observation.landmark);
      if (point == points.end()) continue;
      seen += fmt::format("{}{:.3f} {:.3f} {}", seen.empty() ? "" : " ", observation.pixel.x() + kPixelCentre,
                          observation.pixel.y() + kPixelCentre, observation.landmark);
      point->second.track += fmt::format(" {} {}", image_id, index++);
      if (const auto pixel = camera.project(T_camera_map * point->second.landmark->position)) {
        point->second.error_sum += (*pixel - observation.pixel).norm();
        ++point->second.observations;
      }
    }
    model.images += fmt::format("{} {} {} {}/{}.jpg\n{}\n", image_id, pose_text(T_camera_map),
                                camera_ids.at(keyframe.camera), keyframe.camera, keyframe.stamp, seen);
  }

  model.points = kFrame;
  model.points += "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (const auto& [id, point] : points) model.points += point_line(id, point);
  return model;
}

}  // namespace slamfuse::service
