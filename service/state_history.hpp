// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "common/pose_estimate.hpp"
#include "common/thinned_history.hpp"
#include "common/time.hpp"

namespace slamfuse::service {

/// A time [ns] in which a source of poses was in one state.
struct StateStretch {
  common::Nanoseconds from = 0;
  common::Nanoseconds to = 0;
  common::TrackingState state = common::TrackingState::kLost;
};

/// When a source was in which state: every estimate counts until the next one, at most kCoveredByPose. Neighbours in
/// one state are one stretch, so that hours take little room. Where there would be more than `most`, every two
/// neighbours become one of the worse state: what is told is then worse than it was, never better.
class StateHistory {
 public:
  /// `most` >= 2.
  explicit StateHistory(std::size_t most = common::kKeepAll) : most_(most) {}

  /// The next estimate. One whose stamp steps back counts from the last one's on.
  void push(common::Nanoseconds stamp, common::TrackingState state);

  /// In order, none empty; between two of them nothing was heard.
  const std::vector<StateStretch>& stretches() const { return stretches_; }

 private:
  void join_neighbours();

  std::size_t most_;
  std::vector<StateStretch> stretches_;
  common::Nanoseconds newest_ = 0;
};

/// The same from `from` to `to` without holes: where nothing was heard is LOST, but for the first kCoveredByPose before
/// the first estimate, since the first measurement may be a moment late. Empty when nothing was ever heard.
std::vector<StateStretch> without_holes(const std::vector<StateStretch>& stretches, common::Nanoseconds from,
                                        common::Nanoseconds to);

}  // namespace slamfuse::service
