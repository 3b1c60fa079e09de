// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_folder_recording.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/image_decoder.hpp"
#include "common/recording_span.hpp"
#include "common/sensor_yaml.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kCameraName = "cam0";

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Whether name a comes before name b when runs of digits are compared as numbers; names that differ only in leading
/// zeros by their bytes.
bool natural_less(std::string_view a, std::string_view b) {
  std::string_view rest_a = a;
  std::string_view rest_b = b;
  const auto take_number = [](std::string_view& text) {
    std::size_t end = 0;
    while (end < text.size() && is_digit(text[end])) ++end;
    std::string_view digits = text.substr(0, end);
    text.remove_prefix(end);
    digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
    return digits;
  };
  while (!rest_a.empty() && !rest_b.empty()) {
    if (is_digit(rest_a.front()) && is_digit(rest_b.front())) {
      const std::string_view number_a = take_number(rest_a);
      const std::string_view number_b = take_number(rest_b);
      if (number_a.size() != number_b.size()) return number_a.size() < number_b.size();
      if (number_a != number_b) return number_a < number_b;
      continue;
    }
    if (rest_a.front() != rest_b.front()) return rest_a.front() < rest_b.front();
    rest_a.remove_prefix(1);
    rest_b.remove_prefix(1);
  }
  if (rest_a.empty() != rest_b.empty()) return rest_a.empty();
  return a < b;
}

bool has_image_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  constexpr std::array<std::string_view, 5> kExtensions{".jpg", ".jpeg", ".png", ".pgm", ".ppm"};
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

std::vector<std::string> image_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code); !code && entry != std::filesystem::directory_iterator();
       entry.increment(code)) {
    if (has_image_extension(entry->path())) names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end(), natural_less);
  return names;
}

class ImageFolderRecording final : public Recording {
 public:
  ImageFolderRecording(RecordingInfo info, std::vector<std::string> names, double rate_hz)
      : info_(std::move(info)), names_(std::move(names)), rate_hz_(rate_hz) {}

  const RecordingInfo& info() const override { return info_; }

  Result<std::optional<RecordingItem>> next() override {
    if (at_ == names_.size()) return std::nullopt;
    const Nanoseconds stamp = from_seconds(static_cast<double>(at_) / rate_hz_);
    const CameraCalibration& camera = info_.calibration.cameras.at(kCameraName);
    Result<GrayImage> image = read_gray_image(info_.path / names_[at_++], ImageSize{camera.width, camera.height});
    if (!image) return RejectedMessage{stamp, kCameraName, image.error().message};
    return SensorMessage(Image{stamp, kCameraName, camera.width, camera.height, std::move(image->pixels)});
  }

 private:
  RecordingInfo info_;
  std::vector<std::string> names_;
  double rate_hz_;
  std::size_t at_ = 0;
};

}  // namespace

bool is_image_folder(const std::filesystem::path& path) {
  std::error_code code;
  return std::filesystem::exists(path / "sensor.yaml", code) && !std::filesystem::exists(path / "data.csv", code);
}

Result<std::unique_ptr<Recording>> open_image_folder_recording(const std::filesystem::path& path) {
  const Result<CameraYaml> camera = read_camera_yaml(path / "sensor.yaml");
  if (!camera) return tl::unexpected(camera.error());
  if (!camera->rate_hz) {
    return invalid_input((path / "sensor.yaml").string() +
                         ": key rate_hz is missing (a folder of images has no stamps)");
  }
  std::vector<std::string> names = image_names(path);
  RecordingInfo info;
  info.path = path;
  info.format = "images";
  info.calibration.cameras[kCameraName] = camera->calibration;
  const std::size_t last = names.empty() ? 0 : names.size() - 1;
  info.sensors[kCameraName] = {SensorKind::kCamera, names.size(), 0,
                               from_seconds(static_cast<double>(last) / *camera->rate_hz)};
  const Result<void> span = set_time_span(info);
  if (!span) return tl::unexpected(span.error());
  return std::make_unique<ImageFolderRecording>(std::move(info), std::move(names), *camera->rate_hz);
}

}  // namespace slamfuse::common
