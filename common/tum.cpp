// SPDX-License-Identifier: BSD-3-Clause
#include "common/tum.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "common/angle.hpp"
#include "common/number_rows.hpp"

namespace slamfuse::common {
namespace {

constexpr std::size_t kTumColumns = 8;
constexpr std::size_t kPlanarColumns = 4;
/// How far a quaternion's length may be off 1: printed with four decimals it stays well inside.
constexpr double kQuaternionTolerance = 1e-3;

/// The columns after the stamp as numbers.
Result<std::vector<double>> numbers_after_stamp(const NumberRow& row) {
  std::vector<double> numbers;
  for (std::size_t i = 1; i < row.columns.size(); ++i) {
    const Result<double> number = row.number(i);
    if (!number) return tl::unexpected(number.error());
    numbers.push_back(*number);
  }
  return numbers;
}

Result<StampedPose3> read_pose(const NumberRow& row) {
  const Result<Nanoseconds> stamp = row.stamp(0);
  if (!stamp) return tl::unexpected(stamp.error());
  const Result<std::vector<double>> v = numbers_after_stamp(row);
  if (!v) return tl::unexpected(v.error());
  if (row.columns.size() == kPlanarColumns) {
    return StampedPose3{*stamp, to_pose3(Pose2{v->at(0), v->at(1), normalize_angle(v->at(2))})};
  }
  const Eigen::Quaterniond rotation(v->at(6), v->at(3), v->at(4), v->at(5));
  if (std::abs(rotation.norm() - 1.0) > kQuaternionTolerance) {
    return invalid_input(fmt::format("{}: the quaternion's length is {}, expected 1 within {}", row.where,
                                     rotation.norm(), kQuaternionTolerance));
  }
  return StampedPose3{*stamp, {{v->at(0), v->at(1), v->at(2)}, rotation.normalized()}};
}

}  // namespace

Result<Trajectory3> read_trajectory(const std::filesystem::path& path) {
  Trajectory3 trajectory;
  std::size_t columns = 0;
  const Result<void> read = read_number_rows(path, [&](const NumberRow& row) -> Result<void> {
    const std::size_t found = row.columns.size();
    if (found != kTumColumns && found != kPlanarColumns) {
      return invalid_input(fmt::format(
          "{}: {} columns, expected 8 (timestamp x y z qx qy qz qw) or 4 (timestamp x y theta)", row.where, found));
    }
    if (columns != 0 && found != columns) {
      return invalid_input(fmt::format("{}: {} columns, the lines before have {}", row.where, found, columns));
    }
    columns = found;
    Result<StampedPose3> pose = read_pose(row);
    if (!pose) return tl::unexpected(pose.error());
    trajectory.push_back(*pose);
    return {};
  });
  if (!read) return tl::unexpected(read.error());
  return trajectory;
}

std::string to_tum(const Trajectory3& trajectory) {
  fmt::memory_buffer text;
  for (const auto& [stamp, pose] : trajectory) {
    const Eigen::Vector3d& t = pose.translation;
    const Eigen::Quaterniond& q = pose.rotation;
    fmt::format_to(std::back_inserter(text), "{} {:.9f} {:.9f} {:.9f} {:.12f} {:.12f} {:.12f} {:.12f}\n",
                   format_seconds(stamp), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return fmt::to_string(text);
}

std::string to_tum(const Trajectory2& trajectory) { return to_tum(to_spatial(trajectory)); }

Result<void> write_tum(const std::filesystem::path& path, const Trajectory3& trajectory) {
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << to_tum(trajectory);
  file.close();
  if (!file) return failed(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
  return {};
}

Result<void> write_tum(const std::filesystem::path& path, const Trajectory2& trajectory) {
  return write_tum(path, to_spatial(trajectory));
}

}  // namespace slamfuse::common
