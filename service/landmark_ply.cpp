// SPDX-License-Identifier: BSD-3-Clause
#include "service/landmark_ply.hpp"

#include <fmt/format.h>
#include <Eigen/Core>

namespace slamfuse::service {

std::string landmarks_to_ply(const std::vector<common::Landmark>& landmarks, const fusion::Alignment& alignment) {
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\ncomment slamfuse visual landmarks, frame {}\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      alignment.accepted ? "laser_map" : "visual_map", landmarks.size());
  for (const auto& landmark : landmarks) {
    Eigen::Vector3d point = landmark.position;
    if (alignment.accepted) {
      point.head<2>() = alignment.map * Eigen::Vector2d(point.head<2>());
      point.z() *= alignment.mean_scale;
    }
    ply += fmt::format("{:.4f} {:.4f} {:.4f} {} {} {}\n", point.x(), point.y(), point.z(), landmark.gray, landmark.gray,
                       landmark.gray);
  }
  return ply;
}

}  // namespace slamfuse::service
