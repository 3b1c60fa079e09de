// SPDX-License-Identifier: BSD-3-Clause
#include "common/recording_samples.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <sstream>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace slamfuse::common::samples {

namespace fs = std::filesystem;

const char* const kCameraYaml =
    "sensor_type: camera\n"
    "T_BS:\n"
    "  rows: 4\n"
    "  cols: 4\n"
    "  data: [0, 0, 1, 0.1, -1, 0, 0, 0.2, 0, -1, 0, 0.3, 0, 0, 0, 1]\n"
    "rate_hz: 5\n"
    "resolution: [16, 12]\n"
    "camera_model: pinhole\n"
    "intrinsics: [20, 21, 7.5, 5.5]\n"
    "distortion_model: radial-tangential\n"
    "distortion_coefficients: [-0.1, 0.02, 0.001, 0.002]\n"
    "shutter: global\n";

const char* const kLaserYaml =
    "sensor_type: laser_2d\n"
    "T_BS:\n"
    "  data: [1, 0, 0, 0.12, 0, 1, 0, 0, 0, 0, 1, 0.28, 0, 0, 0, 1]\n"
    "angle_min: -1.5\n"
    "angle_increment: 1.0\n"
    "beams: 4\n"
    "sweep_duration: 0.02\n"
    "range_min: 0.1\n"
    "range_max: 5.0\n";

TemporaryFolder::TemporaryFolder() {
  static std::atomic<int> counter{0};
  path_ = fs::temp_directory_path() /
          ("slamfuse_test_" + std::to_string(getpid()) + "_" + std::to_string(counter.fetch_add(1)));
  fs::create_directories(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void write_file(const fs::path& path, const std::string& content) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

std::string read_file(const fs::path& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

std::string encoded_image(const std::string& extension, int seed, int width, int height, bool colour) {
  cv::Mat image(height, width, colour ? CV_8UC3 : CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto value = static_cast<unsigned char>((x * 13 + y * 7 + seed * 29) % 256);
      if (colour) {
        image.at<cv::Vec3b>(y, x) = {value, value, value};
      } else {
        image.at<unsigned char>(y, x) = value;
      }
    }
  }
  std::vector<unsigned char> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

void write_euroc_sample(const fs::path& folder) {
  const auto stamp = [](int milliseconds) {
    return std::to_string(kSampleStart + Nanoseconds{milliseconds} * 1'000'000);
  };
  std::string odometry = "#timestamp [ns],x [m],y [m],theta [rad],v [m s^-1],omega [rad s^-1]\n";
  for (int i = 0; i <= 10; ++i) {
    odometry += stamp(i * 100) + "," + std::to_string(i * 0.05) + ",0.0,0.01,0.5,0.1\n";
  }
  std::string scans = "#timestamp [ns] of the first beam,ranges [m]; 0 = no return\n";
  std::string images = "#timestamp [ns],filename\n";
  for (int i = 0; i < 5; ++i) {
    const std::string at = stamp(i * 200);
    scans += at + ",1.5,0,2.25,7.0\n";
    images += at + "," + at + ".jpg\n";
    write_file(folder / "cam0" / "data" / (at + ".jpg"), encoded_image(".jpg", i));
  }
  write_file(folder / "odom0" / "data.csv", odometry);
  write_file(folder / "odom0" / "sensor.yaml", "sensor_type: wheel_odometry\n");
  write_file(folder / "laser0" / "data.csv", scans);
  write_file(folder / "laser0" / "sensor.yaml", kLaserYaml);
  write_file(folder / "cam0" / "data.csv", images);
  write_file(folder / "cam0" / "sensor.yaml", kCameraYaml);
}

std::size_t Contents::count(const std::string& sensor) const {
  return static_cast<std::size_t>(
      std::count_if(messages.begin(), messages.end(), [&](const SensorMessage& m) { return sensor_of(m) == sensor; }));
}

Contents read_all(Recording& recording) {
  Contents contents;
  while (true) {
    Result<std::optional<RecordingItem>> item = recording.next();
    if (!item) {
      contents.error = item.error();
      return contents;
    }
    if (!*item) return contents;
    if (auto* rejected = std::get_if<RejectedMessage>(&**item)) {
      contents.rejected.push_back(std::move(*rejected));
    } else {
      contents.messages.push_back(std::move(std::get<SensorMessage>(**item)));
    }
  }
}

Contents open_and_read_all(const fs::path& path) {
  const Result<std::unique_ptr<Recording>> recording = open_recording(path);
  if (recording) return read_all(**recording);
  Contents contents;
  contents.error = recording.error();
  return contents;
}

}  // namespace slamfuse::common::samples
