// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_conversions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "common/laser_reading.hpp"

namespace slamfuse::common {
namespace {

constexpr std::size_t kFewestReadings = 2;
constexpr std::size_t kMostReadings = 100'000;
/// Geometry repeated with every scan may differ by rounding, not by more [m, rad].
constexpr float kGeometryTolerance = 1e-4F;
constexpr std::size_t kMostDistortion = 5;

/// Bytes a pixel and where its colours stand.
struct PixelLayout {
  std::size_t bytes;
  std::size_t red;
  std::size_t green;
  std::size_t blue;
};

const PixelLayout* layout_of(const std::string& encoding) {
  static const std::map<std::string, PixelLayout> layouts{
      {"mono8", {1, 0, 0, 0}}, {"8UC1", {1, 0, 0, 0}},  {"rgb8", {3, 0, 1, 2}}, {"bgr8", {3, 2, 1, 0}},
      {"8UC3", {3, 2, 1, 0}},  {"rgba8", {4, 0, 1, 2}}, {"bgra8", {4, 2, 1, 0}}};
  const auto found = layouts.find(encoding);
  return found == layouts.end() ? nullptr : &found->second;
}

/// The angle from the first beam to the last [rad].
double aperture_of(const RosLaserScan& scan) {
  const std::size_t steps = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  return static_cast<double>(steps) * std::abs(static_cast<double>(scan.angle_increment));
}

}  // namespace

double stated_sweep(const RosLaserScan& scan) {
  constexpr double kLongestSweep = 60.0;
  const std::size_t steps = scan.ranges.empty() ? 0 : scan.ranges.size() - 1;
  const double sweep = static_cast<double>(steps) * static_cast<double>(scan.time_increment);
  return sweep > 0.0 && sweep <= kLongestSweep ? sweep : 0.0;
}

bool is_full_circle(const RosLaserScan& scan) {
  constexpr double kNearly = 0.97;
  return aperture_of(scan) >= kNearly * 2.0 * std::numbers::pi;
}

Result<LaserCalibration> laser_calibration_of(const RosLaserScan& scan, const Pose3& T_base_laser) {
  const std::size_t readings = scan.ranges.size();
  if (readings < kFewestReadings || readings > kMostReadings) {
    return invalid_input(
        fmt::format("scan of {} readings (allowed: {} to {})", readings, kFewestReadings, kMostReadings));
  }
  const double aperture = aperture_of(scan);
  // Some drivers give the last beam of a full turn again, or round the increment up.
  constexpr double kWidest = 2.0 * std::numbers::pi * 1.01;
  if (!std::isfinite(scan.angle_min) || !(aperture > 0.0 && aperture <= kWidest)) {
    return invalid_input(fmt::format("scan from {} rad in steps of {} rad (allowed: up to one turn)", scan.angle_min,
                                     scan.angle_increment));
  }
  if (!(scan.range_min >= 0.0F && scan.range_max > scan.range_min && std::isfinite(scan.range_max))) {
    return invalid_input(fmt::format("scan of ranges from {} to {} m (allowed: 0 <= range_min < range_max)",
                                     scan.range_min, scan.range_max));
  }
  LaserCalibration laser;
  laser.T_base_laser = T_base_laser;
  laser.angle_min = static_cast<double>(scan.angle_min);
  laser.angle_increment = static_cast<double>(scan.angle_increment);
  laser.beams = static_cast<int>(readings);
  laser.range_min = static_cast<double>(scan.range_min);
  laser.range_max = static_cast<double>(scan.range_max);
  if (!is_full_circle(scan)) laser.sweep_duration = stated_sweep(scan);
  return laser;
}

Result<LaserScan> to_laser_scan(const RosLaserScan& scan, const std::string& sensor, const LaserCalibration& laser) {
  const auto stated = laser_calibration_of(scan, laser.T_base_laser);
  if (!stated) return tl::unexpected(stated.error());
  const double turned = std::abs(stated->angle_increment - laser.angle_increment) * laser.beams;
  if (stated->beams != laser.beams || std::abs(stated->angle_min - laser.angle_min) > kGeometryTolerance ||
      turned > kGeometryTolerance || std::abs(stated->range_max - laser.range_max) > kGeometryTolerance) {
    return invalid_input(
        fmt::format("scan of {} readings from {:.6f} rad in steps of {:.6f} rad up to {} m, unlike "
                    "the first with {} from {:.6f} in steps of {:.6f} up to {} m",
                    stated->beams, stated->angle_min, stated->angle_increment, stated->range_max, laser.beams,
                    laser.angle_min, laser.angle_increment, laser.range_max));
  }
  LaserScan message{scan.header.stamp, sensor, {}};
  message.ranges.reserve(scan.ranges.size());
  for (const float range : scan.ranges) {
    const bool measured = std::isfinite(range);
    const float otherwise = range > 0.0F ? kBeyondRange : kNoMeasurement;
    message.ranges.push_back(measured ? as_range(static_cast<double>(range), laser) : otherwise);
  }
  return message;
}

WheelOdometry to_wheel_odometry(const RosOdometry& odometry, const std::string& sensor, const Pose2& T_child_base) {
  return {odometry.header.stamp, sensor, to_pose2(odometry.pose) * T_child_base, odometry.forward_speed,
          odometry.turn_rate};
}

Pose3 looking_forward() {
  Eigen::Matrix3d rotation;
  rotation << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return {Eigen::Vector3d::Zero(), Eigen::Quaterniond(rotation)};
}

Result<CameraCalibration> camera_calibration_of(const RosCameraInfo& info, const Pose3& T_base_camera) {
  const auto further = info.d.begin() + static_cast<std::ptrdiff_t>(std::min(info.d.size(), kMostDistortion));
  const bool plain = std::all_of(further, info.d.end(), [](double d) { return d == 0.0; });
  const bool known = info.distortion_model.empty() || info.distortion_model == "plumb_bob" ||
                     (info.distortion_model == "rational_polynomial" && plain);
  if (!known || !plain) {
    return invalid_input(
        fmt::format("distortion model '{}' of {} numbers (known: plumb_bob)", info.distortion_model, info.d.size()));
  }
  constexpr std::uint32_t kLargestSide = 65'535;
  const bool possible = info.k[0] > 0.0 && info.k[4] > 0.0 && info.width > 0 && info.height > 0 &&
                        info.width <= kLargestSide && info.height <= kLargestSide &&
                        std::all_of(info.k.begin(), info.k.end(), [](double k) { return std::isfinite(k); }) &&
                        std::all_of(info.d.begin(), info.d.end(), [](double d) { return std::isfinite(d); });
  if (!possible) return invalid_input("not calibrated");
  const auto distortion = [&](std::size_t i) { return i < info.d.size() ? info.d[i] : 0.0; };
  CameraCalibration camera;
  camera.T_base_camera = T_base_camera;
  camera.width = static_cast<int>(info.width);
  camera.height = static_cast<int>(info.height);
  camera.fx = info.k[0];
  camera.fy = info.k[4];
  camera.cx = info.k[2];
  camera.cy = info.k[5];
  camera.k1 = distortion(0);
  camera.k2 = distortion(1);
  camera.p1 = distortion(2);
  camera.p2 = distortion(3);
  camera.k3 = distortion(4);
  return camera;
}

bool is_gray_or_colour(const std::string& encoding) { return layout_of(encoding) != nullptr; }

Result<GrayImage> to_gray(const RosImage& image, ImageSize expected) {
  const PixelLayout* const layout = layout_of(image.encoding);
  if (layout == nullptr) return invalid_input("encoding '" + image.encoding + "' (known: 8 bit gray, RGB and BGR)");
  if (image.width != static_cast<std::uint32_t>(expected.width) ||
      image.height != static_cast<std::uint32_t>(expected.height)) {
    return invalid_input(fmt::format("image of {}x{} pixels, its calibration is for {}x{}", image.width, image.height,
                                     expected.width, expected.height));
  }
  if (image.width == 0 || image.height == 0) return invalid_input("image without pixels");
  const std::size_t row_bytes = image.width * layout->bytes;
  if (image.step < row_bytes || image.data.size() / image.height < image.step) {
    return invalid_input(
        fmt::format("image of {} rows of {} bytes with {} bytes of data", image.height, image.step, image.data.size()));
  }
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(image.width) * image.height);
  for (std::size_t row = 0; row < image.height; ++row) {
    const auto line = image.data.subspan(row * image.step, row_bytes);
    for (std::size_t at = 0; at < row_bytes; at += layout->bytes) {
      const unsigned luma =
          (299U * line[at + layout->red] + 587U * line[at + layout->green] + 114U * line[at + layout->blue] + 500U) /
          1000U;
      pixels.push_back(static_cast<std::uint8_t>(luma));
    }
  }
  return GrayImage{expected, std::make_shared<const std::vector<std::uint8_t>>(std::move(pixels))};
}

}  // namespace slamfuse::common
