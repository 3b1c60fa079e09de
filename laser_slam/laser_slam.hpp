// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "common/calibration.hpp"
#include "common/error.hpp"
#include "common/occupancy_grid.hpp"
#include "common/slam_module.hpp"
#include "common/thinned_history.hpp"
#include "laser_slam/laser_slam_options.hpp"

namespace slamfuse::laser_slam {

/// 2D laser SLAM: a Rao-Blackwellised particle filter with scan-matched proposals and adaptive resampling (Grisetti,
/// Stachniss, Burgard: Improved Techniques for Grid Mapping with Rao-Blackwellized Particle Filters, T-RO 2007) on
/// log-odds grid maps whose cells also keep the running mean of their endpoints.
///
/// Takes the scans of one laser and wheel odometry (which may be missing), in arrival order. Every good scan gives an
/// estimate with the scan's own stamp: the pose of base_link in the map frame at its first beam. The map frame is
/// base_link at the first scan; one in which no beam met anything begins no map and is rejected. Some scans, after
/// motion, also update the particles and their maps.
///
/// Deterministic in the sequence of calls and the seed; the number of threads changes nothing but the time taken.
class LaserSlam : public common::SlamModule {
 public:
  /// A filter for the scans named `sensor`. `threads` >= 1 work on the particles inside process(). Errors
  /// (kInvalidInput): a calibration that cannot be used (no increment, beams < 0, range_min < 0, range_max <=
  /// range_min, not finite, a sweep of over a minute, a laser that is not mounted level, upright or upside down), a
  /// mapping range of more than 4000 cells.
  static common::Result<std::unique_ptr<LaserSlam>> create(const LaserSlamOptions& options, const std::string& sensor,
                                                           const common::LaserCalibration& calibration,
                                                           std::uint64_t seed, int threads,
                                                           std::size_t most_kept = common::kKeepAll);
  ~LaserSlam() override;

  common::PoseSource source() const override { return common::PoseSource::kLaser; }
  bool wants(const common::SensorMessage& message) const override;
  common::ProcessResult process(const common::SensorMessage& message) override;
  /// SetPose draws the particles around the pose in the best particle's map, or in the restored one when the first scan
  /// comes; without a map, with a pose or a standard deviation beyond 20 km or a covariance that is none it is answered
  /// by an event on the next estimate, as is a pose to where nothing is mapped yet, which is taken. Reset forgets all
  /// and starts a new map epoch. Relocalise cannot be done while mapping and is answered by an event on the next
  /// estimate.
  void execute(const common::Command& command) override;
  /// Adjusts the path of all updates so far and the map to the loops among them, see refine_path(): final_trajectory(),
  /// grid() and serialize() then tell the adjusted ones, until the next filter update. Does nothing where the options
  /// say so and in a map that was restored.
  void refine();
  /// The refined path or the best particle's; scans between two updates are placed between them by their matched
  /// increments. Poses of earlier map epochs are left out.
  common::Trajectory2 final_trajectory() const override;

  /// The refined map or the best particle's. Empty (width 0) before the first scan.
  common::OccupancyGrid grid() const;

  /// That map and the pose in it, to continue from later: versioned, compressed, checksummed (see map_state.hpp).
  /// Errors (kFailed): nothing mapped yet, a map too large to save.
  common::Result<std::string> serialize() const;
  /// Continues in a map that serialize() gave: all particles start in it at its pose, in a new map epoch. Errors
  /// (kInvalidInput): not such a state, cut, altered, of a newer version or another cell size; nothing changed then.
  common::Result<void> restore(const std::string& state);

 private:
  class Impl;
  explicit LaserSlam(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace slamfuse::laser_slam
