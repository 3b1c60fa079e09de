// SPDX-License-Identifier: BSD-3-Clause
#include "common/euroc_rows.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/angle.hpp"
#include "common/image_decoder.hpp"
#include "common/laser_reading.hpp"
#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

Result<std::vector<double>> read_numbers(const StampedRow& row) {
  std::vector<std::string_view> fields;
  split_at_commas(row.text, fields);
  std::vector<double> numbers;
  numbers.reserve(fields.size());
  for (const std::string_view field : fields) {
    const std::optional<double> number = parse_real(field);
    if (!number) {
      return invalid_input("value " + std::to_string(numbers.size() + 1) + " behind the stamp is " + in_quotes(field) +
                           " (allowed: finite numbers)");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

tl::unexpected<Error> wrong_count(std::size_t count, const std::string& allowed) {
  return invalid_input(std::to_string(count) + " values behind the stamp (allowed: " + allowed + ")");
}

}  // namespace

Result<SensorMessage> read_odometry_row(const StampedRow& row, const std::string& sensor) {
  const Result<std::vector<double>> numbers = read_numbers(row);
  if (!numbers) return tl::unexpected(numbers.error());
  const std::vector<double>& n = *numbers;
  if (n.size() != 3 && n.size() != 5) return wrong_count(n.size(), "x, y, theta and perhaps v, omega");
  WheelOdometry odometry{row.stamp, sensor, {n[0], n[1], normalize_angle(n[2])}, 0.0, 0.0};
  if (n.size() == 5) {
    odometry.forward_speed = n[3];
    odometry.turn_rate = n[4];
  }
  return odometry;
}

Result<SensorMessage> read_laser_row(const StampedRow& row, const std::string& sensor, const LaserCalibration& laser) {
  const Result<std::vector<double>> readings = read_numbers(row);
  if (!readings) return tl::unexpected(readings.error());
  if (readings->size() != static_cast<std::size_t>(laser.beams)) {
    return wrong_count(readings->size(), std::to_string(laser.beams) + " ranges");
  }
  LaserScan scan{row.stamp, sensor, {}};
  scan.ranges.reserve(readings->size());
  for (const double reading : *readings) {
    if (reading < 0.0) return invalid_input("range " + std::to_string(reading) + " (allowed: 0 and above)");
    scan.ranges.push_back(as_range(reading, laser));
  }
  return scan;
}

Result<SensorMessage> read_camera_row(const StampedRow& row, const std::string& sensor, const CameraCalibration& camera,
                                      const std::filesystem::path& folder) {
  std::vector<std::string_view> fields;
  split_at_commas(row.text, fields);
  const std::filesystem::path name(fields.front());
  if (name.empty() || name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end() ||
      fields.front().find('\0') != std::string_view::npos) {
    return invalid_input("file name " + in_quotes(fields.front()) +
                         " (allowed: a file inside the sensor's data folder)");
  }
  Result<GrayImage> image = read_gray_image(folder / name, ImageSize{camera.width, camera.height});
  if (!image) return tl::unexpected(image.error());
  return Image{row.stamp, sensor, camera.width, camera.height, std::move(image->pixels)};
}

Result<SensorMessage> read_imu_row(const StampedRow& row, const std::string& sensor) {
  const Result<std::vector<double>> numbers = read_numbers(row);
  if (!numbers) return tl::unexpected(numbers.error());
  const std::vector<double>& n = *numbers;
  if (n.size() != 6) return wrong_count(n.size(), "6");
  return Imu{row.stamp, sensor, {n[0], n[1], n[2]}, {n[3], n[4], n[5]}};
}

}  // namespace slamfuse::common
