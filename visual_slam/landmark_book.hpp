// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/landmark.hpp"
#include "visual_slam/camera_tracks.hpp"
#include "visual_slam/ekf.hpp"
#include "visual_slam/landmark_archive.hpp"
#include "visual_slam/landmark_recogniser.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

/// What is known of the landmarks besides their place in the filter: how they look, how often they were found, and
/// those that have left it.
class LandmarkBook {
 public:
  explicit LandmarkBook(const VisualSlamOptions& options)
      : options_(options), recogniser_(options.recognition), archive_(options.map.max_archived) {}

  std::size_t size() const { return records_.size(); }
  void clear();
  /// The landmarks of known place.
  std::vector<LandmarkId> known(const Ekf& filter) const;

  /// A landmark was seen the first time, at a pixel of a picture, maybe on a known object. Returns its number.
  LandmarkId enter(const cv::Mat& picture, const Eigen::Vector2d& pixel, common::Nanoseconds stamp, std::string object);
  /// A landmark of a saved map. It is never dropped, and nothing that is known of it changes. To be told before any
  /// other landmark.
  void restore(const common::Landmark& landmark);
  void forget(LandmarkId landmark);
  /// A measurement of the landmark was accepted. Returns how long it had not been seen [s].
  double confirm(LandmarkId landmark, common::Nanoseconds stamp);
  /// Whether the landmark was found again after it was seen first: some features never are.
  bool was_found_again(LandmarkId landmark) const { return records_.at(landmark).found > 1; }
  /// A measurement of the landmark was wrong.
  void fail(LandmarkId landmark);
  bool seen_at(LandmarkId landmark, common::Nanoseconds stamp) const {
    return records_.at(landmark).last_seen == stamp;
  }

  /// Looks in the picture for landmarks of the filter of known place that should be in view and are not among
  /// `followed`. `twist` as in make_bearing. Those not found are counted as failures when `count_failures`.
  std::vector<Track> recognise(const Ekf& filter, const Camera& camera, const BodyTwist& twist, const cv::Mat& picture,
                               const std::set<LandmarkId>& followed, bool count_failures);
  /// The same for landmarks that have left the filter: at most `wanted` that are found return to it.
  std::vector<Track> recall(Ekf& filter, const Camera& camera, const BodyTwist& twist, const cv::Mat& picture,
                            int wanted);
  /// Takes another look at the landmarks found in a picture.
  void learn_looks(const Ekf& filter, const Camera& camera, const cv::Mat& picture, std::span<const Track> tracks);

  /// Landmarks that fail too often.
  std::vector<LandmarkId> failing() const;
  /// Those over the limit of the map: the ones found least often go first, of these the longest unseen, none followed.
  std::vector<LandmarkId> surplus(const std::set<LandmarkId>& followed) const;
  /// Keeps the landmarks that are about to leave the filter, as far as their place is known.
  void archive(const Ekf& filter, std::span<const LandmarkId> leaving);
  /// The landmarks that have left the filter; their places follow the keyframes.
  LandmarkArchive& archived() { return archive_; }
  /// Those of them that have not been seen since a stamp.
  std::vector<common::Landmark> unseen_since(const Ekf& filter, common::Nanoseconds stamp) const;
  /// All landmarks of known place, of the filter and archived, by rising number.
  std::vector<common::Landmark> landmarks(const Ekf& filter) const;

 private:
  struct Record {
    int found = 1;
    int failed = 0;
    common::Nanoseconds last_seen = 0;
    bool fixed = false;  // of a saved map
    std::uint8_t gray = 0;
    std::vector<std::uint8_t> descriptor = {};
    std::string object = {};
  };

  struct Place {
    LandmarkId landmark = 0;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
  };

  /// The first of the landmarks that are not of a saved map.
  std::map<LandmarkId, Record>::const_iterator first_own() const { return records_.lower_bound(first_own_); }
  std::optional<common::Landmark> landmark(const Ekf& filter, LandmarkId id, const Record& record) const;
  std::optional<RecognitionCandidate> candidate(const Ekf& filter, const Camera& camera, const BodyTwist& twist,
                                                LandmarkId landmark, const MapPoint& point) const;

  VisualSlamOptions options_;
  LandmarkRecogniser recogniser_;
  LandmarkArchive archive_;
  std::map<LandmarkId, Record> records_;
  std::vector<Place> fixed_;  // of the saved map, which is large: what is asked of all of it must be cheap
  LandmarkId first_own_ = 1;  // those of the saved map have smaller numbers
  LandmarkId next_ = 1;
};

/// Where a landmark should appear in an image taken now; empty when outside the lens's field of view.
std::optional<Eigen::Vector2d> predict_pixel(const Ekf& filter, const Camera& camera, LandmarkId landmark,
                                             const BodyPose& row_shift = {});

}  // namespace slamfuse::visual_slam
