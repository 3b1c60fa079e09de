// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::common {

/// Whether the folder holds a `sensor.yaml` and no `data.csv`, which would make it one sensor of an EuRoC folder.
bool is_image_folder(const std::filesystem::path& path);

/// Opens a folder of images (JPEG, PNG, PGM, PPM by their extension) with a camera's `sensor.yaml` (see
/// sensor_yaml.hpp), whose `rate_hz` is required here. The images come in the natural order of their names (img2 before
/// img10) as "cam0", the first at 0 s, then one every 1 / rate_hz. Images that cannot be used come as RejectedMessage
/// and keep their place in time. Errors (kInvalidInput): the sensor.yaml, no image.
Result<std::unique_ptr<Recording>> open_image_folder_recording(const std::filesystem::path& path);

}  // namespace slamfuse::common
