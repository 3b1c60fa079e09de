// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// Whether the folder (or its `mav0`) holds sensor folders of the EuRoC/ASL layout: camN, laserN, odomN, imuN.
bool is_euroc_folder(const std::filesystem::path& path);

/// Opens an EuRoC/ASL folder. Each camN and laserN needs `sensor.yaml` and `data.csv`, odomN and imuN need `data.csv`;
/// other folders are left alone. The csv files are read through once here for their stamps, images are not opened.
/// Messages come merged by stamp, of equal stamps odometry first, then imu, laser, camera, each by name; rows and
/// images that cannot be used come as RejectedMessage. The body frame of the recording is taken as base_link. Errors:
/// see open_recording.
Result<std::unique_ptr<Recording>> open_euroc_recording(const std::filesystem::path& path);

/// The poses of `state_groundtruth_estimate0/data.csv` (`timestamp [ns], p_x, p_y, p_z [m], q_w, q_x, q_y, q_z, ...`)
/// in the plane, empty when there is no such file. Error: a row that cannot be read; ground truth has no bad messages.
Result<Trajectory2> read_euroc_ground_truth(const std::filesystem::path& path);

}  // namespace slamfuse::common
