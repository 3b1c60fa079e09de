// SPDX-License-Identifier: BSD-3-Clause
#include "common/carmen_reference.hpp"

#include <fmt/format.h>

#include "common/angle.hpp"
#include "common/number_rows.hpp"

namespace slamfuse::common {
namespace {

constexpr std::size_t kColumns = 6;

Result<StampedPose2> read_pose(const NumberRow& row) {
  if (row.columns.size() != kColumns) {
    return invalid_input(fmt::format("{}: {} columns, expected 6 (scan_index ipc_stamp logger_stamp x y theta)",
                                     row.where, row.columns.size()));
  }
  const Result<Nanoseconds> stamp = row.stamp(1);
  if (!stamp) return tl::unexpected(stamp.error());
  double values[kColumns] = {};
  for (const std::size_t i : {0, 3, 4, 5}) {
    const Result<double> value = row.number(i);
    if (!value) return tl::unexpected(value.error());
    values[i] = *value;
  }
  return StampedPose2{*stamp, {values[3], values[4], normalize_angle(values[5])}};
}

}  // namespace

bool is_carmen_reference(const std::filesystem::path& path) {
  bool six_columns = false;
  // The error only ends the reading after the first row.
  static_cast<void>(read_number_rows(path, [&](const NumberRow& row) -> Result<void> {
    six_columns = row.columns.size() == kColumns;
    return invalid_input("");
  }));
  return six_columns;
}

Result<Trajectory2> read_carmen_reference(const std::filesystem::path& path) {
  Trajectory2 trajectory;
  const Result<void> read = read_number_rows(path, [&](const NumberRow& row) -> Result<void> {
    const Result<StampedPose2> pose = read_pose(row);
    if (!pose) return tl::unexpected(pose.error());
    trajectory.push_back(*pose);
    return {};
  });
  if (!read) return tl::unexpected(read.error());
  return trajectory;
}

Trajectory2 sensor_trajectory(const Trajectory2& base, const Pose2& T_base_sensor) {
  Trajectory2 sensor;
  sensor.reserve(base.size());
  for (const StampedPose2& pose : base) sensor.push_back({pose.stamp, pose.pose * T_base_sensor});
  return sensor;
}

}  // namespace slamfuse::common
