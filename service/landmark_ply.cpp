// SPDX-License-Identifier: BSD-3-Clause
#include "service/landmark_ply.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include "fusion/fused_map.hpp"

namespace slamfuse::service {

std::string landmarks_to_ply(const std::vector<common::Landmark>& landmarks, const fusion::Alignment& alignment) {
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\ncomment slamfuse visual landmarks, frame {}\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
      alignment.accepted ? "laser_map" : "visual_map", landmarks.size());
  for (const auto& landmark : alignment.accepted ? fusion::to_laser_frame(landmarks, alignment) : landmarks) {
    const Eigen::Vector3d& point = landmark.position;
    ply += fmt::format("{:.4f} {:.4f} {:.4f} {} {} {}\n", point.x(), point.y(), point.z(), landmark.gray, landmark.gray,
                       landmark.gray);
  }
  return ply;
}

}  // namespace slamfuse::service
