// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/alignment_keeper.hpp"

#include <algorithm>

namespace slamfuse::fusion {
namespace {

bool closed_loop(const common::PoseEstimate& estimate) {
  return std::any_of(estimate.events.begin(), estimate.events.end(),
                     [](const common::Event& event) { return event.kind == "loop_closed"; });
}

}  // namespace

void AlignmentKeeper::add(const common::PoseEstimate& estimate) {
  if (estimate.source == common::PoseSource::kVisual) {
    visual_.push({estimate.stamp, estimate.pose});
    visual_closed_loop_ = visual_closed_loop_ || closed_loop(estimate);
    return;
  }
  if (!laser_.items().empty() && !visual_.items().empty()) {
    path_ += (estimate.pose.translation() - laser_.items().back().pose.translation()).norm();
  }
  laser_.push({estimate.stamp, estimate.pose});
  laser_closed_loop_ = laser_closed_loop_ || closed_loop(estimate);
}

void AlignmentKeeper::forget(common::PoseSource source) {
  (source == common::PoseSource::kVisual ? visual_ : laser_).clear();
  path_ = 0.0;
  next_path_ = 0.0;
  laser_closed_loop_ = visual_closed_loop_ = false;
  assumed_.reset();
  accepted_.reset();
  last_.reset();
}

bool AlignmentKeeper::due() const {
  if (laser_.items().empty() || visual_.items().empty()) return false;
  if (laser_closed_loop_ && visual_closed_loop_) return true;
  return path_ >= (next_path_ > 0.0 ? next_path_ : schedule_.first_path);
}

std::optional<Alignment> AlignmentKeeper::update() {
  if (!due()) return std::nullopt;
  return align();
}

Alignment AlignmentKeeper::align() {
  next_path_ = std::max(path_, schedule_.first_path) * schedule_.growth;
  laser_closed_loop_ = visual_closed_loop_ = false;
  Alignment attempt = align_trajectories(laser_.items(), visual_.items(), options_, scale_);
  last_ = attempt;
  if (!attempt.accepted) return attempt;
  const auto error = [this](const Alignment& alignment) {
    return typical_error(laser_.items(), visual_.items(), alignment, options_);
  };
  if (!accepted_ || error(attempt) < error(*accepted_)) accepted_ = attempt;
  return attempt;
}

}  // namespace slamfuse::fusion
