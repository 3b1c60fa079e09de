// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

namespace slamfuse::service {

/// COLMAP's text model read as its documentation says, by code that shares nothing with what wrote it.
struct ColmapReader {
  struct Camera {
    std::string model;
    double width = 0.0;
    double height = 0.0;
    std::vector<double> parameters;

    /// COLMAP's camera models PINHOLE, OPENCV and FULL_OPENCV.
    Eigen::Vector2d project(const Eigen::Vector3d& point) const {
      const double u = point.x() / point.z();
      const double v = point.y() / point.z();
      std::vector<double> p = parameters;
      p.resize(12, 0.0);
      const double r2 = u * u + v * v;
      const double radial = (1 + p[4] * r2 + p[5] * r2 * r2 + p[8] * r2 * r2 * r2) /
                            (1 + p[9] * r2 + p[10] * r2 * r2 + p[11] * r2 * r2 * r2);
      const double x = u * radial + 2 * p[6] * u * v + p[7] * (r2 + 2 * u * u);
      const double y = v * radial + 2 * p[7] * u * v + p[6] * (r2 + 2 * v * v);
      return {p[0] * x + p[2], p[1] * y + p[3]};
    }
  };
  struct Image {
    Eigen::Quaterniond rotation;
    Eigen::Vector3d translation;
    int camera = 0;
    std::string name;
    std::vector<std::pair<Eigen::Vector2d, std::int64_t>> points;
  };
  struct Point {
    Eigen::Vector3d position;
    std::array<int, 3> colour{};
    double error = 0.0;
    std::vector<std::pair<int, int>> track;  // image, index of its point
  };

  std::map<int, Camera> cameras;
  std::map<int, Image> images;
  std::map<std::int64_t, Point> points;

  ColmapReader(const std::string& cameras_text, const std::string& images_text, const std::string& points_text) {
    for (std::istringstream& line : lines(cameras_text)) {
      int id = 0;
      Camera camera;
      line >> id >> camera.model >> camera.width >> camera.height;
      for (double value = 0.0; line >> value;) camera.parameters.push_back(value);
      cameras[id] = camera;
    }
    auto image_lines = lines(images_text);
    if (image_lines.size() % 2 != 0) throw std::runtime_error("images.txt: an image without its points");
    for (std::size_t i = 0; i < image_lines.size(); i += 2) {
      int id = 0;
      Image image;
      Eigen::Quaterniond& q = image.rotation;
      Eigen::Vector3d& t = image.translation;
      image_lines[i] >> id >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z() >> image.camera >> image.name;
      double x = 0.0, y = 0.0;
      for (std::int64_t point = 0; image_lines[i + 1] >> x >> y >> point;) image.points.push_back({{x, y}, point});
      images[id] = image;
    }
    for (std::istringstream& line : lines(points_text)) {
      std::int64_t id = 0;
      Point point;
      line >> id >> point.position.x() >> point.position.y() >> point.position.z();
      for (int& channel : point.colour) line >> channel;
      line >> point.error;
      int image = 0;
      for (int index = 0; line >> image >> index;) point.track.emplace_back(image, index);
      points[id] = point;
    }
  }

  /// Distances [px] between the observations of all tracks and where the model puts their points.
  std::vector<double> reprojection_errors() const {
    std::vector<double> errors;
    for (const auto& [id, point] : points) {
      for (const auto& [image_id, index] : point.track) {
        const Image& image = images.at(image_id);
        const auto& [pixel, seen] = image.points.at(static_cast<std::size_t>(index));
        if (seen != id) throw std::runtime_error("a track names an observation of another point");
        const Eigen::Vector3d there = image.rotation * point.position + image.translation;
        errors.push_back((cameras.at(image.camera).project(there) - pixel).norm());
      }
    }
    return errors;
  }

 private:
  /// The lines that are no comments; the points of an image may be an empty line.
  static std::vector<std::istringstream> lines(const std::string& text) {
    std::vector<std::istringstream> result;
    std::istringstream all(text);
    for (std::string line; std::getline(all, line);) {
      if (!line.starts_with('#')) result.emplace_back(line);
    }
    return result;
  }
};

}  // namespace slamfuse::service
