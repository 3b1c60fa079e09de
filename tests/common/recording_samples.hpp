// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/recording.hpp"

namespace slamfuse::common::samples {

/// A folder of its own below the system's temporary folder, removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void write_file(const std::filesystem::path& path, const std::string& content);
std::string read_file(const std::filesystem::path& path);

/// A picture of 16x12 pixels with some structure; `seed` makes them differ. Format by extension: ".jpg", ".png",
/// ".pgm".
std::string encoded_image(const std::string& extension, int seed, int width = 16, int height = 12, bool colour = false);

inline constexpr Nanoseconds kSampleStart = 1'700'000'000'000'000'000;

/// A complete small EuRoC/ASL folder below `folder`: odom0 (10 Hz), laser0 (5 Hz, 4 beams), cam0 (5 Hz, JPEG), 1 s from
/// kSampleStart; scans and images have equal stamps.
void write_euroc_sample(const std::filesystem::path& folder);

extern const char* const kCameraYaml;
extern const char* const kLaserYaml;

/// All that a recording gives. `error` is set when next() ended with one.
struct Contents {
  std::vector<SensorMessage> messages;
  std::vector<RejectedMessage> rejected;
  std::optional<Error> error;

  std::size_t count(const std::string& sensor) const;
};
Contents read_all(Recording& recording);

/// Opens and reads all; the open error ends up in `error`.
Contents open_and_read_all(const std::filesystem::path& path);

}  // namespace slamfuse::common::samples
