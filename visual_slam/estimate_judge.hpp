// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/time.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/landmark_book.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/tracking_monitor.hpp"
#include "visual_slam/trust_chain.hpp"

namespace slamfuse::visual_slam {

/// An event of the visual SLAM.
common::Event visual_event(common::Nanoseconds stamp, std::string kind, std::string detail);

/// Says what an estimate is worth, and tells when that changes: whether the cameras see what they should
/// (TrackingMonitor), and whether what they see can be trusted after the wheels have slipped (TrustChain).
class EstimateJudge {
 public:
  explicit EstimateJudge(const VisualSlamOptions& options);

  common::TrackingState state() const { return monitor_.state(); }
  bool is_tracking() const { return state() == common::TrackingState::kTracking; }
  bool is_lost() const { return state() == common::TrackingState::kLost; }
  /// Whether what is seen may be entered at the estimated pose. Without wheel odometry there is nothing that an image
  /// could contradict: features lost in a quick turn are replaced as long as the constant motion bridges the gap.
  bool map_may_grow() const { return by_wheels_ ? monitor_.map_may_grow() : !is_lost(); }

  /// Whether the estimate may be wrong though the features fit: the odometry contradicts the camera, or has done so and
  /// what is seen (`tracks`) does not hang together with the map from before. Without wheels nothing contradicts.
  bool doubts(const Ekf& filter, const LandmarkBook& book, const std::vector<Track>& tracks, const UpdateReport& report,
              common::Nanoseconds stamp, std::vector<common::Event>& events);
  /// See TrackingMonitor::asks_for_texture.
  bool asks_for_texture(const ImageEvidence& evidence) const { return monitor_.asks_for_texture(evidence); }
  /// Takes what an image showed: whether the cameras still know where they are. Returns whether they have just been
  /// lost.
  bool judge(common::Nanoseconds stamp, const ImageEvidence& evidence, std::vector<common::Event>& events);
  /// Tells of a loop when so many landmarks came back after a long time: once a visit, not once an image.
  void tell_loop(int back_after_long, common::Nanoseconds stamp, std::vector<common::Event>& events);

  /// Nothing is known of the pose: lost until the next good image.
  void lose() { monitor_.lose(); }
  /// The pose came from outside: uncertain until the next good image.
  void pose_was_set() { monitor_.pose_was_set(); }
  /// The robot is somewhere else: whether the map hangs together with one from before is no question any more.
  void moved_elsewhere() { trust_.end(); }
  /// The map was forgotten.
  void clear();

 private:
  TrackingOptions options_;
  RecognitionOptions recognition_;
  bool by_wheels_;
  TrackingMonitor monitor_;
  TrustChain trust_;
  std::optional<common::Nanoseconds> last_loop_;
};

}  // namespace slamfuse::visual_slam
