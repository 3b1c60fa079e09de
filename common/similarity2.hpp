// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "common/pose2.hpp"

namespace slamfuse::common {

/// A planar similarity transform, an element of Sim(2): p -> scale * R(theta) * p + (x, y).
struct Similarity2 {
  double scale = 1.0;  ///< > 0
  Pose2 pose;          ///< rotation and translation [m, rad]

  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const;
  /// A pose brought over: its position is mapped, its heading turned.
  Pose2 operator*(const Pose2& other) const;
  Similarity2 operator*(const Similarity2& other) const;
  Similarity2 inverse() const;
  /// The 3x3 homogeneous matrix.
  Eigen::Matrix3d matrix() const;
};

/// Which transforms a fit may choose from.
enum class FitGroup {
  kRigid,       ///< SE(2): rotation and translation
  kSimilarity,  ///< Sim(2): rotation, translation and one scale
};

/// The transform T minimising sum_i w_i |target_i - T source_i|^2 in closed form (Umeyama 1991). `weights` is empty
/// (all one) or as long as the points. Returns nothing for fewer than two points, lengths that differ, points that all
/// coincide on either side, or points without any correlation (a mirrored circle), for which every angle is as good.
std::optional<Similarity2> fit_similarity(std::span<const Eigen::Vector2d> source,
                                          std::span<const Eigen::Vector2d> target, FitGroup group,
                                          std::span<const double> weights = {});

}  // namespace slamfuse::common
