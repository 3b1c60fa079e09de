// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <Eigen/Core>

#include "fusion/alignment.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {

/// The way between the visual and the laser map frame: the alignment in use (G_LV). What it is off by at a place, the
/// bend of the maps against each other, is in the covariance of what it brings over.
class FrameBridge {
 public:
  /// The robot was moved by other than its wheels, or one of the maps is new.
  void forget_place() { last_visual_.reset(); }
  /// Uses this alignment from now on; nothing closes the bridge. Returns how far the last visual pose is moved by that
  /// in the laser map frame, (x, y, theta); nothing when there was none, or none to compare with.
  std::optional<Eigen::Vector3d> use(const std::optional<Alignment>& alignment);

  /// A visual pose (in the visual map frame) in the laser map frame; nothing without an alignment.
  std::optional<UncertainPose> to_laser(const UncertainPose& visual);
  /// Metres per visual unit; nothing without an alignment.
  std::optional<double> scale() const { return alignment_ ? std::optional(alignment_->mean_scale) : std::nullopt; }
  /// A pose of the laser map frame in the visual one, for setting the visual half's pose; nothing without an alignment.
  /// `is_bend_known`: what the alignment is off by there is in the pose already.
  std::optional<UncertainPose> to_visual(const UncertainPose& laser, bool is_bend_known) const;

 private:
  std::optional<Alignment> alignment_;
  std::optional<common::Pose2> last_visual_;  ///< last brought over, in the visual frame
};

}  // namespace slamfuse::fusion
