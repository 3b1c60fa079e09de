// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/camera_clocks.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "visual_slam/picture.hpp"

namespace slamfuse::visual_slam {

CameraClocks::CameraClocks(const ImageClockOptions& options, const TurnSearchOptions& search,
                           const std::vector<CameraTracks>& cameras)
    : before_(cameras.size(), 0), backlog_(static_cast<std::size_t>(1e6 * options.kept_images)) {
  for (const CameraTracks& seeing : cameras) {
    names_.push_back(seeing.camera.name);
    clocks_.emplace_back(options, search, seeing.camera);
  }
}

void CameraClocks::add(const common::WheelOdometry& odometry) {
  for (ImageClock& clock : clocks_) clock.add(odometry);
}

std::vector<std::size_t> CameraClocks::watch(std::size_t camera, const common::Image& image) {
  std::vector<common::Nanoseconds> before;
  for (const ImageClock& clock : clocks_) before.push_back(clock.correction());
  if (!clocks_[camera].watch(picture_of(image), image.stamp)) return {};
  ImageClock::share(clocks_);
  before_ = std::move(before);
  std::vector<std::size_t> changed;
  for (std::size_t i = 0; i < clocks_.size(); ++i) {
    if (clocks_[i].correction() != before_[i]) changed.push_back(i);
  }
  return changed;
}

bool CameraClocks::may_change() const {
  return std::any_of(clocks_.begin(), clocks_.end(), [](const ImageClock& clock) { return clock.is_watching(); });
}

void CameraClocks::keep(const common::Image& image) {
  if (may_change()) {
    backlog_.add(image);
  } else {
    backlog_.clear();
  }
}

std::size_t CameraClocks::index_of(const common::Image& image) const {
  return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), image.sensor) - names_.begin());
}

std::vector<common::Image> CameraClocks::kept() const {
  std::vector<common::Image> moved(backlog_.images().begin(), backlog_.images().end());
  for (common::Image& image : moved) image.stamp += correction(index_of(image));
  std::stable_sort(moved.begin(), moved.end(),
                   [](const common::Image& a, const common::Image& b) { return a.stamp < b.stamp; });
  return moved;
}

common::Nanoseconds CameraClocks::first_kept() const {
  common::Nanoseconds first = std::numeric_limits<common::Nanoseconds>::max();
  for (const common::Image& image : backlog_.images()) {
    const std::size_t camera = index_of(image);
    first = std::min(first, image.stamp + std::min(before_[camera], correction(camera)));
  }
  return first;
}

}  // namespace slamfuse::visual_slam
