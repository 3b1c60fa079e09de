// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/turn_search.hpp"

#include <array>
#include <cmath>
#include <optional>

#include <opencv2/imgproc.hpp>

#include "common/angle.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr int kReduction = 4;    // pictures are this many times smaller
constexpr int kPatchRadius = 4;  // [px] of the small picture
constexpr int kPatchSide = 2 * kPatchRadius + 1;
constexpr float kMinNorm = 20.0F;           // of a patch without its mean: less is noise
constexpr double kPreferPrediction = 0.05;  // correlation the largest turn must gain over none

using Patch = std::array<float, kPatchSide * kPatchSide>;

/// The patch around a pixel of the full picture, without mean and of length 1; empty outside and where nothing is.
std::optional<Patch> patch_at(const cv::Mat& small, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::lround((pixel.x() + 0.5) / kReduction - 0.5));
  const int y = static_cast<int>(std::lround((pixel.y() + 0.5) / kReduction - 0.5));
  if (x < kPatchRadius || y < kPatchRadius || x >= small.cols - kPatchRadius || y >= small.rows - kPatchRadius) {
    return std::nullopt;
  }
  Patch patch;
  float mean = 0.0F;
  std::size_t i = 0;
  for (int row = y - kPatchRadius; row <= y + kPatchRadius; ++row) {
    const unsigned char* values = small.ptr<unsigned char>(row);
    for (int column = x - kPatchRadius; column <= x + kPatchRadius; ++column) {
      patch[i] = static_cast<float>(values[column]);
      mean += patch[i++];
    }
  }
  mean /= static_cast<float>(patch.size());
  float norm = 0.0F;
  for (float& value : patch) {
    value -= mean;
    norm += value * value;
  }
  norm = std::sqrt(norm);
  if (norm < kMinNorm) return std::nullopt;
  for (float& value : patch) value /= norm;
  return patch;
}

double correlation(const Patch& a, const Patch& b) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return static_cast<double>(sum);
}

}  // namespace

std::optional<Eigen::Vector2d> turned_pixel(const Camera& camera, const Eigen::Vector2d& pixel, double turn) {
  const Eigen::Vector3d in_base = camera.R_base_camera * camera.calibration.undistort(pixel).homogeneous();
  const Eigen::Vector3d after = Eigen::AngleAxisd(-turn, Eigen::Vector3d::UnitZ()) * in_base;
  return camera.calibration.project(camera.R_base_camera.transpose() * after);
}

double TurnSearch::find(std::size_t index, const Camera& camera, const cv::Mat& picture,
                        std::span<const ExpectedFeature> expected) {
  cv::Mat small;
  cv::resize(picture, small, cv::Size(picture.cols / kReduction, picture.rows / kReduction), 0, 0, cv::INTER_AREA);
  const cv::Mat before = std::exchange(previous_[index], small);
  if (before.empty()) return 0.0;
  std::vector<std::pair<Patch, Eigen::Vector2d>> patches;
  for (const ExpectedFeature& feature : expected) {
    if (const std::optional<Patch> patch = patch_at(before, feature.last)) {
      patches.emplace_back(*patch, feature.predicted);
    }
  }
  if (patches.empty()) return 0.0;
  const double step = kReduction / camera.focal_length;
  const double limit = common::to_radians(options_.max_turn);
  const int steps = static_cast<int>(limit / step);
  double best_score = -1.0;
  double best_turn = 0.0;
  for (int i = -steps; i <= steps; ++i) {
    const double turn = i * step;
    double sum = 0.0;
    for (const auto& [patch, pixel] : patches) {
      const std::optional<Eigen::Vector2d> moved = turned_pixel(camera, pixel, turn);
      if (!moved) continue;
      if (const std::optional<Patch> now = patch_at(small, *moved)) sum += correlation(patch, *now);
    }
    const double score = sum / static_cast<double>(patches.size()) - kPreferPrediction * std::abs(turn) / limit;
    if (score > best_score) {
      best_score = score;
      best_turn = turn;
    }
  }
  return best_turn;
}

}  // namespace slamfuse::visual_slam
