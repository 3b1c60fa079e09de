// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/options.hpp"
#include "common/slam_module.hpp"
#include "common/thinned_history.hpp"

namespace slamfuse::service {

/// The sensors whose messages are poses of another SLAM system.
inline const std::string kLaserPose = "laser_pose";
inline const std::string kVisualPose = "visual_pose";

/// The kind of the event that tells of a system that was started again and goes on in the map it had.
inline const std::string kRestarted = "restarted";

/// What a SLAM system that is started again does.
enum class AfterRestart {
  kNewMap,   ///< it makes a new one
  kSameMap,  ///< it goes on in the one it had
};

/// How the poses of other SLAM systems are taken, and how these are told theirs.
struct ExternalPoseOptions {
  double position_sigma = 0.05;
  double heading_sigma = 0.02;
  int poses = 20000;
  AfterRestart laser_restart = AfterRestart::kNewMap;
  AfterRestart visual_restart = AfterRestart::kNewMap;
  double restart_settle = 2.0;
  std::string laser_initialpose;
  std::string visual_initialpose;

  void describe(common::OptionVisitor& visit) {
    visit.real("position_sigma", position_sigma, {1e-4, 10.0}, "m (or the map's unit)",
               "Standard deviation of their positions, where they come without a covariance.");
    visit.real("heading_sigma", heading_sigma, {1e-4, 1.0}, "rad", "Standard deviation of their headings, likewise.");
    visit.integer("poses", poses, {100, 10000000}, "poses", "Kept of the path; longer ones are thinned.");
    const std::vector<std::pair<std::string, AfterRestart>> restarts{{"new_map", AfterRestart::kNewMap},
                                                                     {"same_map", AfterRestart::kSameMap}};
    visit.choice("laser_restart", laser_restart, restarts,
                 "When laser_pose comes from another publisher than before: new_map, nothing of the old one holds; "
                 "same_map, as of AMCL or `serve --map`.");
    visit.choice("visual_restart", visual_restart, restarts, "The same of visual_pose.");
    visit.real("restart_settle", restart_settle, {0.0, 60.0}, "s",
               "After a restart in the same map poses count as LOST for so long: the system begins where it was saved, "
               "until it finds, or is told, where it is.");
    visit.text("laser_initialpose", laser_initialpose,
               "Topic on which the system behind laser_pose is told its pose after a loss, such as "
               "/laser/initialpose; empty: it is not told.");
    visit.text("visual_initialpose", visual_initialpose, "The same behind visual_pose, in that system's own map.");
  }
};

/// Poses of another SLAM system in the place of one half. A pose in another frame than the one before begins a new map
/// epoch, and one of a publisher not heard before where the system makes a new map when it is started again; else it
/// is an event that the system was, and its poses are LOST at first. Commands do nothing here: a PipelineObserver hands
/// them on.
class ExternalPoses : public common::SlamModule {
 public:
  /// `sensor` is kLaserPose or kVisualPose.
  ExternalPoses(std::string sensor, const ExternalPoseOptions& options)
      : sensor_(std::move(sensor)), options_(options), path_(static_cast<std::size_t>(options.poses)) {}

  common::PoseSource source() const override;
  bool wants(const common::SensorMessage& message) const override;
  common::ProcessResult process(const common::SensorMessage& message) override;
  void execute(const common::Command& /*command*/) override {}
  /// The poses of the newest epoch as they came, thinned where they are many.
  common::Trajectory2 final_trajectory() const override { return path_.items(); }

 private:
  /// What this pose tells of the system beside where it is: that its map is another one than before, that it was
  /// started again.
  std::optional<common::Event> news_in(const common::ExternalPose& pose);

  const std::string sensor_;
  const ExternalPoseOptions options_;
  std::string frame_;
  std::set<std::uint64_t> publishers_;
  std::optional<common::Nanoseconds> restarted_at_;
  std::uint32_t epoch_ = 0;
  common::ThinnedHistory<common::StampedPose2> path_;
};

}  // namespace slamfuse::service
