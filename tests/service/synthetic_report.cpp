// SPDX-License-Identifier: BSD-3-Clause
#include "service/synthetic_report.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/angle.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;
using common::TrackingState;

constexpr common::Nanoseconds kStart = 1700000000000000000;
constexpr common::Nanoseconds kStep = 100000000;

common::Pose2 on_loop(double phase, double wobble) {
  return {2.0 * std::cos(phase) + wobble, 3.0 * std::sin(phase) - wobble, common::normalize_angle(phase + 1.5708)};
}

common::OccupancyGrid room() {
  common::OccupancyGrid grid;
  grid.width = 140;
  grid.height = 180;
  grid.origin = {-3.5, -4.5};
  grid.cells.assign(140 * 180, common::OccupancyGrid::kUnknown);
  for (int row = 10; row < 170; ++row) {
    for (int column = 10; column < 130; ++column) {
      const bool wall = row < 12 || row > 167 || column < 12 || column > 127;
      const bool table = row > 70 && row < 110 && column > 55 && column < 85;
      grid.cells[static_cast<std::size_t>(row * 140 + column)] = wall || table ? 100 : 3;
    }
  }
  return grid;
}

ReportSource source(PoseSource which, std::size_t poses, double error) {
  ReportSource source;
  source.source = which;
  StateHistory states;
  for (std::size_t i = 0; i < poses; ++i) {
    const auto t = static_cast<double>(i);
    const common::Nanoseconds stamp = kStart + static_cast<common::Nanoseconds>(i) * kStep;
    const double wobble = error * std::sin(0.05 * t);
    const common::Pose2 pose = on_loop(0.01 * t, wobble);
    source.path.push_back({stamp, pose});
    source.errors.push_back({stamp, std::abs(wobble), 0.1 * wobble});
    if (which == PoseSource::kOdometry) continue;
    common::PoseEstimate estimate;
    estimate.stamp = stamp;
    estimate.source = which;
    estimate.pose = pose;
    if (i > poses / 2 && i < poses / 2 + poses / 20) estimate.state = TrackingState::kUncertain;
    if (which == PoseSource::kVisual && i > poses / 2 + poses / 40 && i < poses / 2 + poses / 20) {
      estimate.state = TrackingState::kLost;
    }
    if (which == PoseSource::kLaser) {
      estimate.health.scan_likelihood = 0.8 + 0.1 * std::sin(0.02 * t);
      estimate.health.effective_particles = 18.0 + 10.0 * std::sin(0.03 * t);
    }
    if (which == PoseSource::kVisual) {
      estimate.health.tracked_features = 40 + static_cast<int>(10.0 * std::sin(0.04 * t));
      estimate.health.inliers = 30 + static_cast<int>(9.0 * std::sin(0.05 * t));
      estimate.health.innovation = 1.0 + 0.5 * std::cos(0.06 * t);
    }
    source.estimates.push_back(estimate);
    states.push(stamp, estimate.state);
    source.updates.push_back({stamp, 5.0 + 4.0 * std::abs(std::sin(0.7 * t)) + (i % 97 == 0 ? 20.0 : 0.0)});
  }
  source.states = states.stretches();
  return source;
}

/// Landmarks on the walls, and the cameras on the way.
StructureAndMotion visual_map() {
  StructureAndMotion map;
  for (int i = 0; i < 80; ++i) {
    common::Landmark landmark;
    landmark.position = {2.8 * std::cos(0.7 * i), 3.9 * std::sin(1.3 * i), 1.0 + 0.8 * std::sin(2.9 * i)};
    landmark.covariance = 0.002 * Eigen::Matrix3d::Identity();
    map.landmarks.push_back(landmark);
  }
  for (int i = 0; i < 60; ++i) {
    const common::Pose2 pose = on_loop(0.1 * i, 0.0);
    map.path.push_back({kStart + 10 * i * kStep, pose});
    map.keyframes.push_back({"cam0", map.path.back().stamp, common::to_pose3(pose), {}});
  }
  return map;
}

common::AnnotatedImage sample_image() {
  common::AnnotatedImage sample;
  sample.image.stamp = kStart + 50 * kStep;
  sample.image.sensor = "cam0";
  sample.image.width = 64;
  sample.image.height = 48;
  sample.image.pixels = std::make_shared<const std::vector<std::uint8_t>>(64 * 48, std::uint8_t{90});
  sample.features = {{{10.0, 10.0}, common::FeatureOutcome::kNew}, {{30.0, 20.0}, common::FeatureOutcome::kRejected}};
  return sample;
}

}  // namespace

ReportData synthetic_report(std::size_t poses) {
  ReportData data;
  data.version = "0.1.0";
  data.seed = 7;
  data.recording = "sim/made_up";
  data.duration_s = 0.1 * static_cast<double>(poses);
  data.wall_s = data.duration_s / 4.0;
  data.real_time_factor = 4.0;
  data.peak_rss_mb = 212.0;
  data.start = kStart;
  data.grid = room();
  for (int i = 0; i < 60; ++i) data.landmarks.emplace_back(2.8 * std::cos(0.7 * i), 3.9 * std::sin(1.3 * i));
  data.visual_map = visual_map();
  data.sample_images = {sample_image()};
  data.sources = {source(PoseSource::kOdometry, poses, 0.6), source(PoseSource::kLaser, poses, 0.04),
                  source(PoseSource::kVisual, poses, 0.12), source(PoseSource::kFused, poses, 0.03)};
  data.accuracy = {{"odometry", "se2", 0.59, 1.2, 0.08, 3.1, 1.0},
                   {"laser", "se2", 0.031, 0.09, 0.006, 0.9, 0.998},
                   {"visual", "se2", 0.12, 0.31, 0.015, 1.7, 0.974},
                   {"fused", "se2", 0.027, 0.08, 0.005, 0.8, 0.999},
                   {"laser_final", "se2", 0.02, 0.06, 0.004, 0.8, 1.0}};
  data.modules = {{"laser", poses, poses, 0, 2, 0.998, 7.1, 9.8, 11.0, 29.0},
                  {"visual", poses, poses, 0, 0, 0.974, 7.0, 9.9, 12.0, 29.0}};
  data.alignment =
      ReportAlignment{true, "held-out pairs agree", "similarity", {1.002, 1.002}, 0.01, 0.071, 0.074, 640, 3.2};
  data.events = {{kStart + 30 * kStep, "laser", "loop_closed", "back at a place seen 21.4 s earlier, 0.12 m corrected"},
                 {kStart + 20 * kStep, "fusion", "aligned", "64 pairs, rms 0.08 m"},
                 {kStart + 90 * kStep, "recording", "rejected", "data/0017.jpg: 12 bytes, no JPEG picture"}};
  return data;
}

}  // namespace slamfuse::service
