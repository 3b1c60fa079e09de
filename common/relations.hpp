// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "common/error.hpp"
#include "common/trajectory.hpp"

namespace slamfuse::common {

/// The true motion between two poses of base_link, as a person marked it.
struct PoseRelation {
  Nanoseconds from = 0;
  Nanoseconds to = 0;
  Pose2 T_from_to;
};

/// Reads a relations file: lines of `t1 t2 x y z roll pitch yaw` (seconds, metres, radians). Errors (kInvalidInput,
/// naming file and line): the file cannot be read or is empty, a line has not eight finite numbers, or a relation
/// leaves the plane (z, roll or pitch is not 0).
Result<std::vector<PoseRelation>> read_relations(const std::filesystem::path& path);

/// Mean and standard deviation (over all, divided by n as in the published tables).
struct MeanAndDeviation {
  double mean = 0.0;
  double deviation = 0.0;
};

/// The errors of a set of relations.
struct RelationErrors {
  std::size_t matched = 0;  ///< relations with a pose at both stamps
  MeanAndDeviation translation_m;
  MeanAndDeviation translation_squared_m2;
  MeanAndDeviation rotation_deg;
  MeanAndDeviation rotation_squared_deg2;
};

struct RelationAccuracy {
  RelationErrors all;
  RelationErrors distant;   ///< only relations whose stamps are more than 60 s apart: the consistency of the whole map
  std::size_t missing = 0;  ///< relations for which the trajectory has no pose at one stamp or both
};

/// The metric of Kuemmerle et al., "On measuring the accuracy of SLAM algorithms", Autonomous Robots 2009: for each
/// relation the estimated relative pose is compared with the true one, delta = T_true^-1 * (T_from^-1 * T_to), and the
/// lengths of its translation and of its turn are averaged. Needs no alignment.
///
/// Stamps match exactly, to the nanosecond. Where the trajectory has several poses with one stamp, the one made first
/// counts. Errors (kInvalidInput): no relation matches.
Result<RelationAccuracy> evaluate_relations(const Trajectory2& trajectory, const std::vector<PoseRelation>& relations);

}  // namespace slamfuse::common
