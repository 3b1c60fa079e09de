// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/occupancy_grid.hpp"
#include "common/slam_module.hpp"
#include "common/thinned_history.hpp"
#include "laser_slam/hypothesis_filter.hpp"
#include "laser_slam/laser_slam_options.hpp"

namespace slamfuse::laser_slam {

/// A finished map to localise in.
struct LocalizationMap {
  std::string name;  ///< what errors call it, e.g. its path
  common::OccupancyGrid grid;
  std::string laser_state;  ///< LaserSlam::serialize() of the same map: knows surfaces better than the grid; may be
                            ///< empty
};

/// Monte Carlo localisation of one laser in a finished map, which never changes: hypotheses of particles (see
/// HypothesisFilter) that a search of the whole map proposes (PoseSearch), the best of them matched to the map's
/// surfaces at every scan (ScanMatcher), and a verdict whether to believe it (LocalizationMonitor).
///
/// Takes the scans of one laser and wheel odometry (which may be missing), in arrival order. Every good scan gives an
/// estimate with the scan's own stamp: the pose of base_link in the map's frame at its first beam. It begins LOST: the
/// pose is searched for. Estimates that are LOST carry the best hypothesis' pose, which nobody should use.
///
/// Deterministic in the sequence of calls and the seed.
class LaserLocalization : public common::SlamModule {
 public:
  /// Localises the scans named `sensor`. Uses `options.localization` and, of the rest, what concerns scans, matching,
  /// motion and maps, not the filter's. Errors (kInvalidInput): a calibration that cannot be used (see LaserSlam), a
  /// grid that cannot be (see surface_map) or is without any free or any occupied cell, a state that does not belong to
  /// LaserSlam or has another cell size than the options, more min_particles than max_particles. Of the path at most
  /// `most_kept` poses are kept, thinned beyond (see common::ThinnedHistory).
  static common::Result<std::unique_ptr<LaserLocalization>> create(const LaserSlamOptions& options,
                                                                   const std::string& sensor,
                                                                   const common::LaserCalibration& calibration,
                                                                   const LocalizationMap& map, std::uint64_t seed,
                                                                   std::size_t most_kept = common::kKeepAll);
  ~LaserLocalization() override;

  common::PoseSource source() const override { return common::PoseSource::kLaser; }
  bool wants(const common::SensorMessage& message) const override;
  common::ProcessResult process(const common::SensorMessage& message) override;
  /// SetPose draws the particles around the pose, which the next scans verify; one that cannot be used is answered by
  /// an event on the next estimate and changes nothing (see check_set_pose). Relocalise searches the whole map. Reset
  /// does the same in a new map epoch: the map itself stays, it is the user's.
  void execute(const common::Command& command) override;
  /// The path as known now. Poses while it was searched for are placed in hindsight, by the motion from when the
  /// hypothesis that turned out right was first held; poses that were never found, and those of earlier epochs, are
  /// left out.
  common::Trajectory2 final_trajectory() const override;

  /// Where the robot may be, at the last scan; most probable first.
  std::vector<Hypothesis> hypotheses() const;

  /// The map as it was given.
  const common::OccupancyGrid& grid() const;

 private:
  class Impl;
  explicit LaserLocalization(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace slamfuse::laser_slam
