// SPDX-License-Identifier: BSD-3-Clause
#include "common/relations.hpp"

#include <cmath>
#include <cstdlib>
#include <map>

#include <fmt/format.h>

#include "common/angle.hpp"
#include "common/number_rows.hpp"

namespace slamfuse::common {
namespace {

constexpr std::size_t kColumns = 8;
/// Relations over more time than this tell about the whole map, not about local drift.
constexpr Nanoseconds kDistant = 60 * kNanosecondsPerSecond;

Result<PoseRelation> read_relation(const NumberRow& row) {
  if (row.columns.size() != kColumns) {
    return invalid_input(
        fmt::format("{}: {} columns, expected 8 (t1 t2 x y z roll pitch yaw)", row.where, row.columns.size()));
  }
  const Result<Nanoseconds> from = row.stamp(0);
  if (!from) return tl::unexpected(from.error());
  const Result<Nanoseconds> to = row.stamp(1);
  if (!to) return tl::unexpected(to.error());
  double values[kColumns] = {};
  for (std::size_t i = 2; i < kColumns; ++i) {
    const Result<double> value = row.number(i);
    if (!value) return tl::unexpected(value.error());
    values[i] = *value;
  }
  const auto& [t1, t2, x, y, z, roll, pitch, yaw] = values;
  if (z != 0.0 || roll != 0.0 || pitch != 0.0) {
    return invalid_input(fmt::format("{}: z {}, roll {}, pitch {}: expected 0, only planar relations are known",
                                     row.where, z, roll, pitch));
  }
  return PoseRelation{*from, *to, {x, y, normalize_angle(yaw)}};
}

MeanAndDeviation mean_and_deviation(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto count = static_cast<double>(values.size());
  double mean = 0.0;
  for (const double value : values) mean += value / count;
  double variance = 0.0;
  for (const double value : values) variance += (value - mean) * (value - mean) / count;
  return {mean, std::sqrt(variance)};
}

std::vector<double> squares(std::vector<double> values) {
  for (double& value : values) value *= value;
  return values;
}

/// Collects the errors of single relations.
struct ErrorList {
  std::vector<double> translation;
  std::vector<double> rotation;

  void add(const Pose2& delta) {
    translation.push_back(delta.translation().norm());
    rotation.push_back(to_degrees(std::abs(delta.theta)));
  }
  RelationErrors summary() const {
    return {translation.size(), mean_and_deviation(translation), mean_and_deviation(squares(translation)),
            mean_and_deviation(rotation), mean_and_deviation(squares(rotation))};
  }
};

}  // namespace

Result<std::vector<PoseRelation>> read_relations(const std::filesystem::path& path) {
  std::vector<PoseRelation> relations;
  const Result<void> read = read_number_rows(path, [&](const NumberRow& row) -> Result<void> {
    const Result<PoseRelation> relation = read_relation(row);
    if (!relation) return tl::unexpected(relation.error());
    relations.push_back(*relation);
    return {};
  });
  if (!read) return tl::unexpected(read.error());
  return relations;
}

Result<RelationAccuracy> evaluate_relations(const Trajectory2& trajectory, const std::vector<PoseRelation>& relations) {
  std::map<Nanoseconds, Pose2> poses;
  for (const StampedPose2& pose : trajectory) poses.emplace(pose.stamp, pose.pose);  // keeps the first

  RelationAccuracy accuracy;
  ErrorList all;
  ErrorList distant;
  for (const PoseRelation& relation : relations) {
    const auto from = poses.find(relation.from);
    const auto to = poses.find(relation.to);
    if (from == poses.end() || to == poses.end()) {
      ++accuracy.missing;
      continue;
    }
    const Pose2 delta = relation.T_from_to.inverse() * (from->second.inverse() * to->second);
    all.add(delta);
    if (std::abs(relation.to - relation.from) > kDistant) distant.add(delta);
  }
  if (all.translation.empty()) {
    return invalid_input(fmt::format("none of the {} relations has its two stamps among the {} poses", relations.size(),
                                     trajectory.size()));
  }
  accuracy.all = all.summary();
  accuracy.distant = distant.summary();
  return accuracy;
}

}  // namespace slamfuse::common
