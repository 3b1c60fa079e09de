// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/relocaliser.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Geometry>

#include "common/angle.hpp"
#include "visual_slam/descriptor.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Nanoseconds;
using common::Pose2;

constexpr double kElsewhere = 0.7;             // [m]
constexpr double kElsewhereTurn = 0.35;        // [rad] poses nearer than these to each other are the same answer
constexpr std::size_t kRace = 4;               // hypotheses carried to the next image
constexpr double kLandmarkSigmas = 2.0;        // of a landmark's own uncertainty it may be off
constexpr double kSmallBaseline = 0.2;         // [m] two landmarks nearer than this do not tell a pose
constexpr int kRounds = 3;                     // of choosing who agrees and fitting to them
constexpr double kSharedPositionSigma = 0.03;  // [m]
constexpr double kSharedHeadingSigma = 0.015;  // [rad] of errors that matches share: of places, of the odometry between
constexpr double kMaxPositionSigma = 0.15;     // [m] a pose known worse is not claimed
constexpr double kMaxHeadingSigma = 0.07;      // [rad]

bool elsewhere(const Pose2& a, const Pose2& b) {
  return (a.translation() - b.translation()).norm() > kElsewhere ||
         std::abs(common::normalize_angle(a.theta - b.theta)) > kElsewhereTurn;
}

/// A sight from base_link at another moment: `then` is T_now_base of that moment.
Sight seen_from(const Sight& sight, const BodyPose& then) {
  Sight result = sight;
  result.origin = then.rotation * sight.origin + then.position;
  result.ray = then.rotation * sight.ray;
  return result;
}

}  // namespace

void Relocaliser::clear() {
  images_.clear();
  race_.clear();
  best_.reset();
}

std::vector<Relocaliser::Match> Relocaliser::match(const LandmarkIndex& index, const Glimpse& glimpse,
                                                   const cv::Mat& picture,
                                                   std::span<const Eigen::Vector2d> features) const {
  const std::vector<std::vector<std::uint8_t>> described = describe(picture, features);
  cv::Mat rows;
  std::vector<std::size_t> feature_of;
  for (std::size_t i = 0; i < described.size(); ++i) {
    if (described[i].empty()) continue;
    rows.push_back(cv::Mat(described[i], true).reshape(1, 1));
    feature_of.push_back(i);
  }
  std::vector<Match> matches;
  for (const LandmarkMatch& one : index.match(rows)) {
    const PlacedLandmark& landmark = index.landmarks()[static_cast<std::size_t>(one.landmark)];
    const Eigen::Vector2d& pixel = features[feature_of[static_cast<std::size_t>(one.feature)]];
    const Bearing bearing = make_bearing(*glimpse.camera, pixel, 1.0, glimpse.twist);
    const Sight in_camera{.origin = glimpse.lever_scale * glimpse.camera->t_base_camera,
                          .ray = (glimpse.camera->R_base_camera * bearing.point.homogeneous()).normalized(),
                          .landmark = landmark.position,
                          .landmark_variance = landmark.variance};
    matches.push_back({seen_from(in_camera, bearing.row_shift), landmark.id});
  }
  return matches;
}

std::vector<Relocaliser::Evidence> Relocaliser::gather() const {
  std::vector<Evidence> evidence;
  const Pose2 from_odometry = images_.back().odometry.inverse();
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const Pose2 then = from_odometry * images_[i].odometry;
    for (const Match& match : images_[i].matches) {
      evidence.push_back({seen_from(match.sight, then), match.landmark, static_cast<int>(i)});
    }
  }
  return evidence;
}

bool Relocaliser::agrees(const Sight& sight, const Pose2& pose) const {
  const double error = sight_error(sight, pose);
  if (!(error < 1.0)) return false;
  const double own = kLandmarkSigmas * std::sqrt(sight.landmark_variance) / line_of_sight(sight, pose).norm();
  return error < std::hypot(options_.inlier_radius * pixel_, own);
}

Relocaliser::Hypothesis Relocaliser::judge(const std::vector<Evidence>& evidence, const Pose2& pose) const {
  Hypothesis result{pose, 0, 0.0};
  std::vector<std::int64_t> seen;
  const double cut = options_.inlier_radius * pixel_;
  for (const Evidence& one : evidence) {
    result.error += std::min(sight_error(one.sight, pose), cut);
    if (agrees(one.sight, pose)) seen.push_back(one.landmark);
  }
  std::sort(seen.begin(), seen.end());
  result.landmarks = static_cast<int>(std::unique(seen.begin(), seen.end()) - seen.begin());
  return result;
}

std::optional<RefinedPose> Relocaliser::refine(const std::vector<Evidence>& evidence, const Pose2& pose) const {
  std::optional<RefinedPose> refined = RefinedPose{pose, Eigen::Matrix3d::Identity()};
  for (int round = 0; round < kRounds && refined; ++round) {
    std::vector<Sight> agreeing;
    for (const Evidence& one : evidence) {
      if (agrees(one.sight, refined->pose)) agreeing.push_back(one.sight);
    }
    if (agreeing.size() < 2) return std::nullopt;
    refined = refine_pose(agreeing, refined->pose, 0.5 * options_.inlier_radius * pixel_);
  }
  return refined;
}

std::vector<Relocaliser::Hypothesis> Relocaliser::propose(const std::vector<Evidence>& evidence,
                                                          Nanoseconds stamp) const {
  std::vector<Hypothesis> hypotheses;
  for (const Pose2& pose : race_) hypotheses.push_back(judge(evidence, pose));
  if (evidence.size() >= 2) {
    std::mt19937_64 engine(seed_ ^ static_cast<std::uint64_t>(stamp));
    for (int i = 0; i < options_.hypotheses; ++i) {
      const Evidence& a = evidence[engine() % evidence.size()];
      const Evidence& b = evidence[engine() % evidence.size()];
      if ((a.sight.landmark - b.sight.landmark).norm() < kSmallBaseline) continue;
      if (const std::optional<Pose2> pose = pose_from_two_sights(a.sight, b.sight)) {
        hypotheses.push_back(judge(evidence, *pose));
      }
    }
  }
  std::stable_sort(hypotheses.begin(), hypotheses.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.landmarks != b.landmarks ? a.landmarks > b.landmarks : a.error < b.error;
  });
  std::vector<Hypothesis> different;
  for (const Hypothesis& one : hypotheses) {
    const bool is_new = std::all_of(different.begin(), different.end(),
                                    [&](const Hypothesis& other) { return elsewhere(one.pose, other.pose); });
    if (is_new) different.push_back(one);
    if (different.size() == kRace) break;
  }
  return different;
}

std::optional<Relocalisation> Relocaliser::add(const LandmarkIndex& index, const Glimpse& glimpse,
                                               const cv::Mat& picture, std::span<const Eigen::Vector2d> features) {
  pixel_ = 1.0 / glimpse.camera->focal_length;
  if (!images_.empty()) {
    const Pose2 driven = images_.back().odometry.inverse() * glimpse.odometry;
    for (Pose2& pose : race_) pose = pose * driven;
  }
  images_.push_back({glimpse.stamp, glimpse.odometry, match(index, glimpse, picture, features)});
  const Nanoseconds oldest = glimpse.stamp - common::from_seconds(options_.memory);
  while (images_.front().stamp < oldest || static_cast<int>(images_.size()) > options_.max_images) images_.pop_front();

  const std::vector<Evidence> evidence = gather();
  std::vector<Hypothesis> race = propose(evidence, glimpse.stamp);
  race_.clear();
  for (Hypothesis& one : race) {
    if (const std::optional<RefinedPose> refined = refine(evidence, one.pose)) {
      const Hypothesis better = judge(evidence, refined->pose);
      if (better.landmarks >= one.landmarks) one = better;
    }
    race_.push_back(one.pose);
  }
  best_.reset();
  if (race.empty()) return std::nullopt;
  const auto winner = std::max_element(
      race.begin(), race.end(), [](const Hypothesis& a, const Hypothesis& b) { return a.landmarks < b.landmarks; });
  const std::optional<RefinedPose> refined = refine(evidence, winner->pose);
  if (!refined) return std::nullopt;
  Relocalisation result{.pose = refined->pose, .covariance = refined->covariance, .landmarks = winner->landmarks};
  for (const Hypothesis& one : race) {
    if (elsewhere(one.pose, refined->pose)) result.runner_up = std::max(result.runner_up, one.landmarks);
  }
  std::set<int> images;
  for (const Evidence& one : evidence) {
    if (agrees(one.sight, refined->pose)) images.insert(one.image);
  }
  result.images = static_cast<int>(images.size());
  best_ = result;
  const bool known = std::sqrt(result.covariance.topLeftCorner<2, 2>().trace()) < kMaxPositionSigma &&
                     std::sqrt(result.covariance(2, 2)) < kMaxHeadingSigma;
  const bool newest_agrees = images.contains(static_cast<int>(images_.size()) - 1);
  if (!known || !newest_agrees || result.landmarks < options_.min_landmarks || result.images < options_.min_images ||
      result.landmarks < options_.clear_lead * result.runner_up) {
    return std::nullopt;
  }
  result.covariance.diagonal() +=
      Eigen::Vector3d(kSharedPositionSigma, kSharedPositionSigma, kSharedHeadingSigma).cwiseAbs2();
  return result;
}

}  // namespace slamfuse::visual_slam
