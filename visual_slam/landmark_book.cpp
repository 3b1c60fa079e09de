// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_book.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <opencv2/core.hpp>

#include "visual_slam/descriptor.hpp"

namespace slamfuse::visual_slam {

std::optional<Eigen::Vector2d> predict_pixel(const Ekf& filter, const Camera& camera, LandmarkId landmark,
                                             const BodyPose& row_shift) {
  const std::optional<Prediction> prediction = filter.predict_bearing(camera, landmark, row_shift);
  if (!prediction) return std::nullopt;
  return camera.calibration.project(prediction->point.homogeneous());
}

void LandmarkBook::clear() {
  records_.clear();
  recogniser_.clear();
}

LandmarkId LandmarkBook::enter(const cv::Mat& picture, const Eigen::Vector2d& pixel, common::Nanoseconds stamp) {
  Record record;
  record.last_seen = stamp;
  record.gray = picture.at<unsigned char>(static_cast<int>(pixel.y()), static_cast<int>(pixel.x()));
  records_.emplace(next_, std::move(record));
  return next_++;
}

void LandmarkBook::forget(LandmarkId landmark) {
  records_.erase(landmark);
  recogniser_.forget(landmark);
}

double LandmarkBook::confirm(LandmarkId landmark, common::Nanoseconds stamp) {
  Record& record = records_.at(landmark);
  ++record.found;
  return common::to_seconds(stamp - std::exchange(record.last_seen, stamp));
}

std::vector<Track> LandmarkBook::recognise(const Ekf& filter, const Camera& camera, const BodyTwist& twist,
                                           const cv::Mat& picture, const std::set<LandmarkId>& followed,
                                           bool count_failures) {
  std::vector<Track> recognised;
  if (!options_.recognition.enabled) return recognised;
  std::vector<RecognitionCandidate> candidates;
  for (const auto& [id, record] : records_) {
    if (followed.contains(id) || !recogniser_.knows(id)) continue;
    if (std::optional<RecognitionCandidate> one = candidate(filter, camera, twist, id)) candidates.push_back(*one);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [this](const auto& a, const auto& b) { return records_.at(a.id).found > records_.at(b.id).found; });
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

std::optional<RecognitionCandidate> LandmarkBook::candidate(const Ekf& filter, const Camera& camera,
                                                            const BodyTwist& twist, LandmarkId landmark) const {
  const std::optional<MapPoint> point = filter.map_point(landmark);
  if (!point) return std::nullopt;
  RecognitionCandidate result;
  result.id = landmark;
  result.view = point->position - filter.camera_centre(camera);
  if (!recogniser_.comparable(landmark, result.view)) return std::nullopt;
  const double border = options_.front_end.border;
  const double pixel_sigma = options_.filter.pixel_sigma;
  const std::optional<Eigen::Vector2d> rough = predict_pixel(filter, camera, landmark);
  if (!rough || !camera.sees(*rough, border)) return std::nullopt;
  const BodyPose row_shift = make_bearing(camera, *rough, pixel_sigma, twist).row_shift;
  const std::optional<Prediction> prediction = filter.predict_bearing(camera, landmark, row_shift);
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
  std::vector<Record*> undescribed;
  for (const Track& track : tracks) {
    const std::optional<MapPoint> point = filter.map_point(track.landmark);
    if (!point) continue;
    recogniser_.remember(track.landmark, picture, track.pixel, point->position - filter.camera_centre(camera));
    Record& record = records_.at(track.landmark);
    if (record.descriptor.empty()) {
      pixels.push_back(track.pixel);
      undescribed.push_back(&record);
    }
  }
  std::vector<std::vector<std::uint8_t>> descriptors = describe(picture, pixels);
  for (std::size_t i = 0; i < undescribed.size(); ++i) undescribed[i]->descriptor = std::move(descriptors[i]);
}

std::vector<LandmarkId> LandmarkBook::failing() const {
  std::vector<LandmarkId> failing;
  for (const auto& [id, record] : records_) {
    if (record.failed > record.found + options_.map.max_failures) failing.push_back(id);
  }
  return failing;
}

std::vector<LandmarkId> LandmarkBook::surplus(const std::set<LandmarkId>& followed) const {
  const std::size_t limit = static_cast<std::size_t>(options_.map.max_landmarks);
  std::vector<LandmarkId> surplus;
  if (records_.size() <= limit) return surplus;
  std::vector<std::tuple<int, common::Nanoseconds, LandmarkId>> idle;
  for (const auto& [id, record] : records_) {
    if (!followed.contains(id)) idle.emplace_back(record.found, record.last_seen, id);
  }
  std::sort(idle.begin(), idle.end());
  for (std::size_t i = 0; i < idle.size() && records_.size() - surplus.size() > limit; ++i) {
    surplus.push_back(std::get<2>(idle[i]));
  }
  return surplus;
}

std::vector<common::Landmark> LandmarkBook::landmarks(const Ekf& filter) const {
  std::vector<common::Landmark> result;
  for (const auto& [id, record] : records_) {
    const std::optional<MapPoint> point = filter.map_point(id);
    if (!point) continue;
    result.push_back({.id = id,
                      .position = point->position,
                      .covariance = point->covariance,
                      .gray = record.gray,
                      .observations = record.found,
                      .descriptor = record.descriptor});
  }
  return result;
}

}  // namespace slamfuse::visual_slam
