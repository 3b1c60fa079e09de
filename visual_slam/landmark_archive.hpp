// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "common/landmark.hpp"
#include "common/pose3.hpp"
#include "common/time.hpp"
#include "visual_slam/ekf.hpp"

namespace slamfuse::visual_slam {

/// A landmark that has left the filter.
struct ArchivedLandmark {
  common::Landmark landmark;                                      ///< as it is believed now; without its views
  common::Nanoseconds last_seen = 0;                              ///< stamp of the image that showed it last
  common::Nanoseconds keyframe = 0;                               ///< stamp of the keyframe it hangs on
  Eigen::Matrix3d relative_covariance = Eigen::Matrix3d::Zero();  ///< see Ekf::covariance_given, for that keyframe
};

/// The landmarks that have left the filter, kept for recognising places over the whole run.
///
/// The filter holds only so many landmarks; seed 000 section II D keeps all features in a database. Here each
/// archived landmark hangs on the keyframe nearest in time to when it was seen last: when the filter corrects that
/// keyframe, the archived place moves along, and when the landmark is needed again it gets the keyframe's error and
/// correlations back. Only what its own error had in common with other landmarks beyond the keyframe's is lost. Over
/// `capacity` those found least go first, of these the oldest.
class LandmarkArchive {
 public:
  explicit LandmarkArchive(int capacity) : capacity_(static_cast<std::size_t>(capacity)) {}

  bool contains(LandmarkId landmark) const { return entries_.contains(landmark); }
  std::size_t size() const { return entries_.size(); }
  common::Nanoseconds last_seen(LandmarkId landmark) const { return entries_.at(landmark).archived.last_seen; }
  void clear();

  /// Keeps a landmark that is still in the filter. Returns the one that had to go for it, if one had.
  std::optional<LandmarkId> add(const Ekf& filter, common::Landmark landmark, common::Nanoseconds last_seen);
  /// Hangs those whose keyframe is gone on another. To be called after each new keyframe.
  void follow(const Ekf& filter);
  /// All of them, where the filter's keyframes say they are now; by rising number.
  std::vector<common::Landmark> landmarks(const Ekf& filter) const;
  /// Takes one out again.
  ArchivedLandmark take(const Ekf& filter, LandmarkId landmark);

 private:
  struct Entry {
    ArchivedLandmark archived;
    common::Pose3 reference;  // where the keyframe was when the landmark was where `archived` says
  };

  std::size_t capacity_;
  std::map<LandmarkId, Entry> entries_;
  std::map<common::Nanoseconds, common::Pose3> keyframes_;  // as of the last call of follow()
};

}  // namespace slamfuse::visual_slam
