// SPDX-License-Identifier: BSD-3-Clause
#include "service/landmark_ply.hpp"

#include <map>

#include <fmt/format.h>

#include <Eigen/Core>
#include "fusion/fused_map.hpp"

namespace slamfuse::service {
namespace {

/// Numbers for the names of known objects, in their order; 0 is no object.
std::map<std::string, int> number_objects(const std::vector<common::Landmark>& landmarks) {
  std::map<std::string, int> numbers{{"", 0}};
  for (const common::Landmark& landmark : landmarks) numbers.emplace(landmark.object, 0);
  int next = 0;
  for (auto& [name, number] : numbers) number = next++;
  return numbers;
}

/// A name that cannot break the header.
std::string on_one_line(std::string name) {
  for (char& c : name) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return name;
}

}  // namespace

std::string landmarks_to_ply(const std::vector<common::Landmark>& landmarks, const fusion::Alignment& alignment) {
  const std::map<std::string, int> objects = number_objects(landmarks);
  std::string ply = fmt::format("ply\nformat ascii 1.0\ncomment slamfuse visual landmarks, frame {}\n",
                                alignment.accepted ? "laser_map" : "visual_map");
  for (const auto& [name, number] : objects) {
    if (number != 0) ply += fmt::format("comment object {} {}\n", number, on_one_line(name));
  }
  ply += fmt::format(
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
      "property uchar green\nproperty uchar blue\nproperty int object\nend_header\n",
      landmarks.size());
  for (const auto& landmark : alignment.accepted ? fusion::to_laser_frame(landmarks, alignment) : landmarks) {
    const Eigen::Vector3d& point = landmark.position;
    ply += fmt::format("{:.4f} {:.4f} {:.4f} {} {} {} {}\n", point.x(), point.y(), point.z(), landmark.gray,
                       landmark.gray, landmark.gray, objects.at(landmark.object));
  }
  return ply;
}

}  // namespace slamfuse::service
