// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "common/calibration.hpp"
#include "common/error.hpp"

namespace slamfuse::common {

/// What the `sensor.yaml` of an EuRoC/ASL folder tells of a camera.
struct CameraYaml {
  CameraCalibration calibration;
  std::optional<double> rate_hz;  ///< [Hz] pictures a second, if stated
};

/// Reads a camera's `sensor.yaml`: `T_BS` (4x4 row-major under `data`, T_base_camera), `resolution` [px], `intrinsics`
/// (fu, fv, cu, cv [px]), `distortion_coefficients` (k1, k2, p1, p2 and perhaps k3), `camera_model` pinhole and
/// `distortion_model` radial-tangential where given, and the readout time from a `shutter` that starts with
/// "rolling, <seconds> s". Other keys (comment, ...) are left alone.
/// Error (kInvalidInput) naming file, line, key and what is allowed: unreadable, a key missing or wrong.
Result<CameraYaml> read_camera_yaml(const std::filesystem::path& path);

/// Reads a laser's `sensor.yaml`: `T_BS` (T_base_laser), `angle_min`, `angle_increment` [rad], `beams`, `range_min`,
/// `range_max` [m], `sweep_duration` [s]. Errors as read_camera_yaml.
Result<LaserCalibration> read_laser_yaml(const std::filesystem::path& path);

}  // namespace slamfuse::common
