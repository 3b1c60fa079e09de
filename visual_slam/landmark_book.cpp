// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_book.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <opencv2/core.hpp>

#include "visual_slam/descriptor.hpp"
#include "visual_slam/view_cone.hpp"

namespace slamfuse::visual_slam {
namespace {

// Landmarks that were archived share errors beyond that of their keyframe (of depth, above all) that are no longer
// known. Taken for independent they would say too much together, so each counts for less.
constexpr double kSharedError = 4.0;  // times the covariance

ViewCone view_cone(const Ekf& filter, const Camera& camera) {
  return {camera, filter.camera_centre(camera), filter.spatial_pose().rotation * camera.R_base_camera.col(2)};
}

}  // namespace

std::optional<Eigen::Vector2d> predict_pixel(const Ekf& filter, const Camera& camera, LandmarkId landmark,
                                             const BodyPose& row_shift) {
  const std::optional<Prediction> prediction = filter.predict_bearing(camera, landmark, row_shift);
  if (!prediction) return std::nullopt;
  return camera.calibration.project(prediction->point.homogeneous());
}

void LandmarkBook::clear() {
  records_.clear();
  fixed_.clear();
  recogniser_.clear();
  archive_.clear();
}

std::vector<LandmarkId> LandmarkBook::known(const Ekf& filter) const {
  std::vector<LandmarkId> known;
  for (const auto& [id, record] : records_) {
    if (filter.is_cartesian(id)) known.push_back(id);
  }
  return known;
}

LandmarkId LandmarkBook::enter(const cv::Mat& picture, const Eigen::Vector2d& pixel, common::Nanoseconds stamp,
                               std::string object) {
  Record record;
  record.last_seen = stamp;
  record.gray = picture.at<unsigned char>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
  record.object = std::move(object);
  records_.emplace(next_, std::move(record));
  return next_++;
}

void LandmarkBook::forget(LandmarkId landmark) {
  records_.erase(landmark);
  if (!archive_.contains(landmark)) recogniser_.forget(landmark);
}

void LandmarkBook::restore(const common::Landmark& landmark) {
  Record record;
  record.found = landmark.observations;
  record.fixed = true;
  record.gray = landmark.gray;
  record.descriptor = landmark.descriptor;
  record.object = landmark.object;
  records_.insert_or_assign(landmark.id, std::move(record));
  recogniser_.restore(landmark.id, landmark.views);
  fixed_.push_back({landmark.id, landmark.position});
  next_ = std::max(next_, landmark.id + 1);
  first_own_ = next_;
}

void LandmarkBook::fail(LandmarkId landmark) {
  Record& record = records_.at(landmark);
  if (!record.fixed) ++record.failed;
}

double LandmarkBook::confirm(LandmarkId landmark, common::Nanoseconds stamp) {
  Record& record = records_.at(landmark);
  if (record.fixed) {
    record.last_seen = stamp;
    return 0.0;
  }
  ++record.found;
  return common::to_seconds(stamp - std::exchange(record.last_seen, stamp));
}

std::vector<Track> LandmarkBook::recognise(const Ekf& filter, const Camera& camera, const BodyTwist& twist,
                                           const cv::Mat& picture, const std::set<LandmarkId>& followed,
                                           bool count_failures) {
  std::vector<Track> recognised;
  if (!options_.recognition.enabled) return recognised;
  std::vector<RecognitionCandidate> candidates;
  const auto consider = [&](LandmarkId id) {
    if (followed.contains(id) || !recogniser_.knows(id)) return;
    const std::optional<MapPoint> point = filter.map_point(id);
    if (!point) return;
    if (std::optional<RecognitionCandidate> one = candidate(filter, camera, twist, id, *point)) {
      candidates.push_back(*one);
    }
  };
  const ViewCone cone = view_cone(filter, camera);
  for (const Place& place : fixed_) {
    if (cone.may_show(place.position)) consider(place.landmark);
  }
  for (auto own = first_own(); own != records_.end(); ++own) consider(own->first);
  std::ranges::sort(candidates, {},
                    [this](const RecognitionCandidate& one) { return std::pair(-records_.at(one.id).found, one.id); });
  const std::size_t limit = static_cast<std::size_t>(options_.recognition.candidates_per_image);
  if (candidates.size() > limit) candidates.resize(limit);
  for (const RecognitionCandidate& one : candidates) {
    if (const std::optional<FoundFeature> found = recogniser_.find(picture, one)) {
      recognised.push_back({found->id, found->pixel});
    } else if (count_failures) {
      fail(one.id);
    }
  }
  return recognised;
}

std::vector<Track> LandmarkBook::recall(Ekf& filter, const Camera& camera, const BodyTwist& twist,
                                        const cv::Mat& picture, int wanted) {
  std::vector<Track> recalled;
  if (!options_.recognition.enabled || wanted <= 0) return recalled;
  struct Known {
    RecognitionCandidate candidate;
    int observations;
  };
  std::vector<Known> candidates;
  const ViewCone cone = view_cone(filter, camera);
  for (const common::Landmark& landmark : archive_.landmarks(filter)) {
    if (!cone.may_show(landmark.position)) continue;
    const MapPoint point{landmark.position, landmark.covariance};
    if (std::optional<RecognitionCandidate> one = candidate(filter, camera, twist, landmark.id, point)) {
      candidates.push_back({*one, landmark.observations});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Known& a, const Known& b) { return a.observations > b.observations; });
  const std::size_t limit = static_cast<std::size_t>(options_.recognition.candidates_per_image);
  if (candidates.size() > limit) candidates.resize(limit);
  for (const Known& one : candidates) {
    const std::optional<FoundFeature> found = recogniser_.find(picture, one.candidate);
    if (!found) continue;
    const ArchivedLandmark archived = archive_.take(filter, found->id);
    filter.add_point(found->id, archived.landmark.position, *filter.keyframe_at(archived.keyframe),
                     kSharedError * archived.relative_covariance);
    Record record;
    record.found = archived.landmark.observations;
    record.last_seen = archived.last_seen;
    record.gray = archived.landmark.gray;
    record.descriptor = archived.landmark.descriptor;
    record.object = archived.landmark.object;
    records_.emplace(found->id, std::move(record));
    recalled.push_back({found->id, found->pixel});
    if (static_cast<int>(recalled.size()) == wanted) break;
  }
  return recalled;
}

std::optional<RecognitionCandidate> LandmarkBook::candidate(const Ekf& filter, const Camera& camera,
                                                            const BodyTwist& twist, LandmarkId landmark,
                                                            const MapPoint& point) const {
  RecognitionCandidate result;
  result.id = landmark;
  result.view = point.position - filter.camera_centre(camera);
  if (!recogniser_.comparable(landmark, result.view)) return std::nullopt;
  const double border = options_.front_end.border;
  const double pixel_sigma = options_.filter.pixel_sigma;
  const auto predict = [&](const BodyPose& row_shift) {
    return filter.has(landmark) ? filter.predict_bearing(camera, landmark, row_shift)
                                : filter.predict_point(camera, point, row_shift);
  };
  const std::optional<Prediction> rough = predict({});
  if (!rough) return std::nullopt;
  const std::optional<Eigen::Vector2d> rough_pixel = camera.calibration.project(rough->point.homogeneous());
  if (!rough_pixel || !camera.sees(*rough_pixel, border)) return std::nullopt;
  const std::optional<Prediction> prediction =
      predict(make_bearing(camera, *rough_pixel, pixel_sigma, twist).row_shift);
  if (!prediction) return std::nullopt;
  const std::optional<Eigen::Vector2d> pixel = camera.calibration.project(prediction->point.homogeneous());
  if (!pixel || !camera.sees(*pixel, border)) return std::nullopt;
  result.predicted = *pixel;
  const double sigma = camera.focal_length * std::sqrt(prediction->covariance.trace()) + pixel_sigma;
  result.radius = std::min(options_.recognition.search_sigma * sigma, options_.recognition.max_search_radius);
  return result;
}

void LandmarkBook::learn_looks(const Ekf& filter, const Camera& camera, const cv::Mat& picture,
                               std::span<const Track> tracks) {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<LandmarkId> seen_anew;
  for (const Track& track : tracks) {
    const std::optional<MapPoint> point = filter.map_point(track.landmark);
    if (!point || records_.at(track.landmark).fixed) continue;
    if (!recogniser_.remember(track.landmark, picture, track.pixel, point->position - filter.camera_centre(camera))) {
      continue;
    }
    pixels.push_back(track.pixel);
    seen_anew.push_back(track.landmark);
  }
  std::vector<std::vector<std::uint8_t>> descriptors = describe(picture, pixels);
  for (std::size_t i = 0; i < seen_anew.size(); ++i) {
    std::vector<std::uint8_t>& first = records_.at(seen_anew[i]).descriptor;
    if (first.empty()) first = descriptors[i];
    recogniser_.describe_last(seen_anew[i], std::move(descriptors[i]));
  }
}

std::vector<LandmarkId> LandmarkBook::failing() const {
  std::vector<LandmarkId> failing;
  for (auto own = first_own(); own != records_.end(); ++own) {
    const auto& [id, record] = *own;
    if (record.failed > record.found + options_.map.max_failures) failing.push_back(id);
  }
  return failing;
}

std::vector<LandmarkId> LandmarkBook::surplus(const std::set<LandmarkId>& followed) const {
  const std::size_t limit = static_cast<std::size_t>(options_.map.max_landmarks);
  std::vector<LandmarkId> surplus;
  if (records_.size() <= limit) return surplus;
  std::size_t estimated = 0;
  std::vector<std::tuple<int, common::Nanoseconds, LandmarkId>> idle;
  for (const auto& [id, record] : records_) {
    if (record.fixed) continue;
    ++estimated;
    if (!followed.contains(id)) idle.emplace_back(record.found, record.last_seen, id);
  }
  std::sort(idle.begin(), idle.end());
  for (std::size_t i = 0; i < idle.size() && estimated - surplus.size() > limit; ++i) {
    surplus.push_back(std::get<2>(idle[i]));
  }
  return surplus;
}

std::optional<common::Landmark> LandmarkBook::landmark(const Ekf& filter, LandmarkId id, const Record& record) const {
  const std::optional<MapPoint> point = filter.map_point(id);
  if (!point) return std::nullopt;
  return common::Landmark{.id = id,
                          .position = point->position,
                          .covariance = point->covariance,
                          .gray = record.gray,
                          .observations = record.found,
                          .descriptor = record.descriptor,
                          .object = record.object,
                          .views = recogniser_.views(id)};
}

void LandmarkBook::archive(const Ekf& filter, std::span<const LandmarkId> leaving) {
  for (const LandmarkId id : leaving) {
    const Record& record = records_.at(id);
    std::optional<common::Landmark> known = landmark(filter, id, record);
    if (!known || known->views.empty()) continue;
    known->views.clear();
    const std::optional<LandmarkId> gone = archive_.add(filter, std::move(*known), record.last_seen);
    if (gone && *gone != id) recogniser_.forget(*gone);
  }
}

std::vector<common::Landmark> LandmarkBook::unseen_since(const Ekf& filter, common::Nanoseconds stamp) const {
  std::vector<common::Landmark> old = landmarks(filter);
  std::erase_if(old, [&](const common::Landmark& landmark) {
    const auto record = records_.find(landmark.id);
    return (record != records_.end() ? record->second.last_seen : archive_.last_seen(landmark.id)) >= stamp;
  });
  return old;
}

std::vector<common::Landmark> LandmarkBook::landmarks(const Ekf& filter) const {
  std::vector<common::Landmark> result;
  for (const auto& [id, record] : records_) {
    if (std::optional<common::Landmark> known = landmark(filter, id, record)) result.push_back(std::move(*known));
  }
  for (common::Landmark& archived : archive_.landmarks(filter)) {
    archived.views = recogniser_.views(archived.id);
    result.push_back(std::move(archived));
  }
  std::ranges::sort(result, {}, &common::Landmark::id);
  return result;
}

}  // namespace slamfuse::visual_slam
