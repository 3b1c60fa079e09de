// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "common/options.hpp"
#include "common/pose_estimate.hpp"
#include "common/thinned_history.hpp"
#include "common/trajectory.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse::fusion {

struct AlignmentScheduleOptions {
  double first_path = 3.0;
  double growth = 1.25;

  void describe(common::OptionVisitor& visit) {
    visit.real("first_path", first_path, {0.1, 1000.0}, "m",
               "Laser path with both halves tracking after which the alignment is first tried.");
    visit.real("growth", growth, {1.01, 10.0}, "", "It is tried again each time that path has grown by this factor.");
  }
};

/// Collects both halves' poses as they come and keeps the best alignment between them. Seed 004 aligns when both halves
/// have closed a loop or mapping ends; here also on request and as the path grows. A new alignment replaces the one in
/// use only if the typical pair fits it better.
class AlignmentKeeper {
 public:
  /// Of each half at most `most_kept` poses are kept, thinned beyond.
  AlignmentKeeper(const AlignmentOptions& options, const AlignmentScheduleOptions& schedule, VisualScale scale,
                  std::size_t most_kept)
      : options_(options), schedule_(schedule), scale_(scale), laser_(most_kept), visual_(most_kept) {}

  /// A pose that may be used (not LOST), and the events that came with it.
  void add(const common::PoseEstimate& estimate);
  /// The map of one half started anew: its poses, and every alignment to them, are void.
  void forget(common::PoseSource source);

  /// Uses an alignment of earlier as long as none fits better.
  void assume(const Alignment& alignment) {
    assumed_ = alignment;
    accepted_ = alignment;
  }
  /// The one of earlier; nothing once it is void.
  const std::optional<Alignment>& assumed() const { return assumed_; }

  /// Aligns when it is due. Returns the attempt, if there was one.
  std::optional<Alignment> update();
  /// Aligns now.
  Alignment align();

  /// The alignment in use: accepted.
  const std::optional<Alignment>& accepted() const { return accepted_; }
  /// The last attempt, refused or not.
  const std::optional<Alignment>& last() const { return last_; }

 private:
  bool due() const;

  AlignmentOptions options_;
  AlignmentScheduleOptions schedule_;
  VisualScale scale_;
  common::ThinnedHistory<common::StampedPose2> laser_;
  common::ThinnedHistory<common::StampedPose2> visual_;
  double path_ = 0.0;       ///< of the laser, since the visual half spoke [m]
  double next_path_ = 0.0;  ///< at which the next attempt is due; 0 before the first
  bool laser_closed_loop_ = false;
  bool visual_closed_loop_ = false;
  std::optional<Alignment> assumed_;
  std::optional<Alignment> accepted_;
  std::optional<Alignment> last_;
};

}  // namespace slamfuse::fusion
