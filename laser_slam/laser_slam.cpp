// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_slam.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "laser_slam/degeneracy.hpp"
#include "laser_slam/frozen_scan.hpp"
#include "laser_slam/input_checks.hpp"
#include "laser_slam/loop_detector.hpp"
#include "laser_slam/map_state.hpp"
#include "laser_slam/motion_accumulator.hpp"
#include "laser_slam/motion_model.hpp"
#include "laser_slam/motion_predictor.hpp"
#include "laser_slam/particle_filter.hpp"
#include "laser_slam/path_log.hpp"
#include "laser_slam/path_refinement.hpp"
#include "laser_slam/pose_floor.hpp"
#include "laser_slam/scan_tracker.hpp"
#include "laser_slam/tracking_monitor.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kEnoughKnown = 0.2;       // share of a scan's beams in mapped space for its agreement to tell anything
constexpr int kFewestKnown = 5;            // and how many of them at least
constexpr double kMostCells = 4000.0;      // reach of a beam in the map; inserting a scan takes 4 B a cell it may meet
constexpr double kDegenerateEvery = 10.0;  // [m] of path between two events of being degenerate

FilterSettings filter_settings(const LaserSlamOptions& options) {
  return {options.particles, options.resample_threshold, options.proposal_spread, options.lost_agreement};
}

}  // namespace

class LaserSlam::Impl {
 public:
  Impl(const LaserSlamOptions& options, std::string sensor, const common::LaserCalibration& calibration,
       std::uint64_t seed, int threads, std::size_t most_kept)
      : options_(options),
        sensor_(std::move(sensor)),
        calibration_(calibration),
        threads_(threads),
        predictor_(options.motion),
        matcher_(options.matcher, options.evidence_gain(calibration.beams)),
        tracker_(matcher_, options.matcher, options.motion),
        filter_(filter_settings(options), matcher_, seed, threads),
        loops_(options.loops),
        monitor_({options.uncertain_agreement, options.lost_agreement, options.lost_time}),
        path_(most_kept),
        motion_(options.motion) {}

  const std::string& sensor() const { return sensor_; }

  void add(const common::WheelOdometry& odometry) {
    predictor_.add(odometry);
    frozen_.moved_to(odometry.pose);
  }

  common::ProcessResult add(const common::LaserScan& scan) {
    if (auto fresh = frozen_.check(scan); !fresh) return {std::nullopt, fresh.error().message};
    common::ProcessResult result;
    const auto beams = project(scan);
    if (!beams) {
      result.rejected = beams.error().message;
      return result;
    }
    if (!started_ && !restored_ && beams->match_points.empty()) {
      // Drawn, it would be a map of free space that every later scan contradicts.
      result.rejected = "no beam met anything: a map begins with the first scan that sees something";
      return result;
    }
    result.estimate = !started_ ? start(scan.stamp, *beams) : step(scan.stamp, *beams);
    return result;
  }

  void set_pose(const common::SetPose& command) {
    if (auto refused = check(command); !refused) return announce("set_pose_refused", refused.error().message);
    if (started_) {
      place(command);
    } else {
      set_pose_ = command;
    }
  }

  void reset() {
    set_pose_.reset();
    restored_.reset();
    path_length_ = 0.0;
    held_at_ = 0.0;
    if (!started_) return;
    started_ = false;
    ++epoch_;
    path_.clear();
    keyframes_.clear();
    refined_.reset();
    degenerate_told_ = -kDegenerateEvery;
    loops_ = LoopDetector(options_.loops);
    monitor_.reset();
    announce("map_reset", fmt::format("map epoch {} begins", epoch_));
  }

  void answer_relocalise() {
    announce("relocalise_refused", "searching the whole map needs a finished map: not while mapping");
  }

  void refine() {
    if (!started_ || refined_ || !can_refine()) return;
    Refined refined{refine_path(keyframes_, filter_.best_path(), matcher_, options_.map, options_.refinement,
                                options_.loops.min_path, threads_),
                    GridMap(options_.map)};
    refined.map = draw_map(keyframes_, refined.path, options_.map);
    refined_ = std::move(refined);
  }

  common::Trajectory2 final_trajectory() const {
    if (!started_) return {};
    return path_.compose(refined_ ? refined_->path : filter_.best_path());
  }

  common::OccupancyGrid grid() const { return started_ ? to_occupancy_grid(map()) : common::OccupancyGrid{}; }

  common::Result<std::string> serialize() const {
    if (!started_ && restored_) return serialize_state(*restored_);  // as it was loaded
    if (!started_) return common::failed("laser_slam: nothing mapped yet, there is no state to save");
    const common::Pose2 pose = refined_ ? refined_->path.back() * motion_.matched() : pose_;
    return serialize_state({pose, path_length_, map()});
  }

  common::Result<void> restore(const std::string& bytes) {
    auto state = parse_state(bytes, options_.map);
    if (!state) return tl::unexpected(state.error());
    reset();
    if (epoch_ == 0) ++epoch_;
    path_length_ = held_at_ = state->path_length;
    restored_ = std::move(*state);
    return {};
  }

 private:
  /// The path and map in hindsight.
  struct Refined {
    std::vector<common::Pose2> path;  // of the keyframes
    GridMap map;
  };

  /// Whether refine() does anything: else no keyframes are kept, which are most of what a long run takes.
  bool can_refine() const { return options_.refinement.enabled && !restored_map_; }

  const GridMap& map() const { return refined_ ? refined_->map : filter_.best().map; }

  void announce(std::string kind, std::string detail) {
    pending_.push_back({0, "laser", std::move(kind), std::move(detail)});
  }

  /// Whether particles can be drawn as a SetPose asks.
  common::Result<void> check(const common::SetPose& command) const {
    if (!started_ && !restored_) return common::failed("there is no map yet in which a pose could be set");
    return check_set_pose(command, pose_floor());
  }

  /// Draws the particles around a pose set from outside.
  void place(const common::SetPose& command) {
    const common::Pose2 pose{command.pose.x, command.pose.y, common::normalize_angle(command.pose.theta)};
    filter_.scatter(pose, command.covariance + pose_floor());
    if (can_refine()) keyframes_.push_back({{}, path_length_, false, {}});
    begin_segment(std::nullopt);
    predictor_.forget_speed();
    monitor_.reset();
    const bool mapped = filter_.best().map.known_at(pose.translation());
    announce("relocalised", mapped ? "the pose was set from outside"
                                   : "the pose was set from outside, to where nothing is mapped yet");
  }

  common::Result<ScanBeams> project(const common::LaserScan& scan) {
    const common::Nanoseconds sweep = options_.compensate_sweep ? common::from_seconds(calibration_.sweep_duration) : 0;
    return project_scan(scan, calibration_,
                        {options_.max_range, options_.map.free_beyond_range, options_.matcher.max_beams},
                        predictor_.begin_sweep(scan.stamp, sweep));
  }

  common::PoseEstimate start(common::Nanoseconds stamp, const ScanBeams& beams) {
    common::Pose2 pose;
    GridMap map(options_.map);
    if (restored_) {
      pose = restored_->pose;
      map = restored_->map;
    } else {
      InsertionScratch scratch;
      map.insert(beams, pose, path_length_, scratch);
    }
    restored_map_ = restored_.has_value();
    restored_.reset();
    keyframes_.clear();
    if (can_refine()) keyframes_.push_back({StoredScan(beams), path_length_, true, {}});
    filter_.start(pose, map);
    predictor_.start(stamp);
    started_ = true;
    last_update_stamp_ = stamp;
    begin_segment(std::nullopt);
    if (set_pose_) place(*std::exchange(set_pose_, std::nullopt));
    return estimate(stamp, beams, matcher_.evaluate(filter_.best().map, beams.match_points, pose_), false);
  }

  common::PoseEstimate step(common::Nanoseconds stamp, const ScanBeams& beams) {
    const MotionPrediction prediction = predictor_.predict(stamp);
    const TrackedScan tracked = tracker_.track(filter_.best().map, beams.match_points, pose_, prediction, predictor_,
                                               loops_.old_before(path_length_));
    follow(stamp, prediction, tracked);
    monitor_.add(stamp, agreement_of(tracked.match.fit, beams));
    const bool closed = loops_.closes(tracked.match.fit.old_share, path_length_);
    if (update_due(stamp)) update(stamp, beams);
    return estimate(stamp, beams, tracked.match.fit, closed);
  }

  /// Takes the scan-to-scan motion: the online pose, and what the next filter update will be told.
  void follow(common::Nanoseconds stamp, const MotionPrediction& prediction, const TrackedScan& tracked) {
    predictor_.finish(stamp, prediction, tracked.increment);
    pose_ = tracked.match.pose;
    path_length_ += std::hypot(tracked.increment.x, tracked.increment.y);
    motion_.add(prediction, tracked);
  }

  bool update_due(common::Nanoseconds stamp) const {
    return motion_.matched_travel().distance >= options_.update_distance ||
           motion_.matched_travel().turn >= options_.update_angle ||
           (options_.update_interval > 0.0 &&
            std::abs(common::to_seconds(stamp - last_update_stamp_)) >= options_.update_interval);
  }

  void update(common::Nanoseconds stamp, const ScanBeams& beams) {
    const common::Pose2 arrival = motion_.matched();
    if (can_refine()) {
      keyframes_.push_back({StoredScan(beams), path_length_, monitor_.may_map(), motion_.candidates()});
    }
    filter_.update(beams, motion_.believed(), path_length_, monitor_.may_map());
    last_update_stamp_ = stamp;
    begin_segment(arrival);
  }

  /// The online path continues from the best particle, wherever it is now.
  void begin_segment(std::optional<common::Pose2> arrival) {
    pose_ = filter_.best().pose;
    motion_.clear();
    refined_.reset();
    path_.begin_segment(arrival);
  }

  std::optional<double> agreement_of(const ScanFit& fit, const ScanBeams& beams) const {
    const double enough = kEnoughKnown * static_cast<double>(beams.match_points.size());
    if (fit.known < std::max<double>(enough, kFewestKnown)) return std::nullopt;
    return fit.agreement;
  }

  common::PoseEstimate estimate(common::Nanoseconds stamp, const ScanBeams& beams, const ScanFit& fit, bool closed) {
    path_.add(stamp, motion_.matched());
    common::PoseEstimate estimate;
    estimate.stamp = stamp;
    estimate.source = common::PoseSource::kLaser;
    estimate.map_epoch = epoch_;
    estimate.pose = pose_;
    estimate.covariance = covariance(fit);
    estimate.state = monitor_.state();
    estimate.health.scan_likelihood = agreement_of(fit, beams);
    estimate.health.effective_particles = filter_.effective_particles();
    estimate.health.degenerate_direction = degenerate_direction(fit.information, options_.degenerate_ratio);
    report_events(estimate, fit, closed);
    return estimate;
  }

  /// Spread of the particles plus that of the match given the motion since the last update. Never zero.
  Eigen::Matrix3d covariance(const ScanFit& fit) const {
    const Eigen::Matrix3d prior = to_parent_frame(motion_.covariance(), pose_).inverse();
    return filter_.spread() + (prior + matcher_.gain() * fit.information).inverse() + pose_floor();
  }

  void report_events(common::PoseEstimate& estimate, const ScanFit& fit, bool closed) {
    if (closed) {
      announce("loop_closed", fmt::format("after {:.1f} m the scan meets surfaces last seen {:.1f} m of path ago",
                                          path_length_, path_length_ - fit.mean_last_path));
    }
    if (monitor_.just_lost())
      announce("lost", fmt::format("the scan agrees with the map by {:.2f} only", fit.agreement));
    if (monitor_.just_found())
      announce("relocalised", fmt::format("the scan agrees with the map by {:.2f}", fit.agreement));
    if (!estimate.health.degenerate_direction) {
      held_at_ = path_length_;
    } else if (path_length_ - held_at_ >= options_.update_distance &&
               path_length_ - degenerate_told_ >= kDegenerateEvery) {
      degenerate_told_ = path_length_;
      announce("degenerate", fmt::format("the scan leaves the position open along {:.0f} deg",
                                         common::to_degrees(*estimate.health.degenerate_direction)));
    }
    for (common::Event& event : pending_) event.stamp = estimate.stamp;
    estimate.events = std::exchange(pending_, {});
  }

  LaserSlamOptions options_;
  std::string sensor_;
  common::LaserCalibration calibration_;
  int threads_;
  MotionPredictor predictor_;
  FrozenScan frozen_;
  ScanMatcher matcher_;
  ScanTracker tracker_;
  ParticleFilter filter_;
  LoopDetector loops_;
  TrackingMonitor monitor_;
  PathLog path_;

  bool started_ = false;
  std::uint32_t epoch_ = 0;
  std::optional<MapState> restored_;         // waits for the first scan
  std::optional<common::SetPose> set_pose_;  // the same: where to begin in it
  common::Pose2 pose_;                       // online, T_map_base at the last scan
  double path_length_ = 0.0;                 // [m] since the map was begun
  common::Nanoseconds last_update_stamp_ = 0;
  std::vector<common::Event> pending_;
  MotionAccumulator motion_;  // since the last filter update

  std::vector<Keyframe> keyframes_;  // one each begin_segment, none where there is nothing to refine
  bool restored_map_ = false;        // the map began as one that was loaded
  std::optional<Refined> refined_;   // of these keyframes

  double held_at_ = 0.0;                        // path length where the scan last held the whole position
  double degenerate_told_ = -kDegenerateEvery;  // path length at the last event
};

LaserSlam::LaserSlam(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LaserSlam::~LaserSlam() = default;

common::Result<std::unique_ptr<LaserSlam>> LaserSlam::create(const LaserSlamOptions& options, const std::string& sensor,
                                                             const common::LaserCalibration& calibration,
                                                             std::uint64_t seed, int threads, std::size_t most_kept) {
  if (auto checked = check_calibration(sensor, calibration); !checked) return tl::unexpected(checked.error());
  if (options.map.mapping_range > kMostCells * options.map.resolution) {
    return common::invalid_input(
        fmt::format("laser.map.mapping_range is {} m with cells of {} m; allowed are up to {} cells",
                    options.map.mapping_range, options.map.resolution, kMostCells));
  }
  return std::unique_ptr<LaserSlam>(
      new LaserSlam(std::make_unique<Impl>(options, sensor, calibration, seed, std::max(threads, 1), most_kept)));
}

bool LaserSlam::wants(const common::SensorMessage& message) const {
  if (std::holds_alternative<common::WheelOdometry>(message)) return true;
  return std::holds_alternative<common::LaserScan>(message) && common::sensor_of(message) == impl_->sensor();
}

common::ProcessResult LaserSlam::process(const common::SensorMessage& message) {
  if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
    if (const auto usable = check_odometry(*odometry); !usable) return {std::nullopt, usable.error().message};
    impl_->add(*odometry);
    return {};
  }
  if (!wants(message)) return {};
  return impl_->add(std::get<common::LaserScan>(message));
}

void LaserSlam::execute(const common::Command& command) {
  if (const auto* set_pose = std::get_if<common::SetPose>(&command)) return impl_->set_pose(*set_pose);
  if (std::holds_alternative<common::Reset>(command)) return impl_->reset();
  impl_->answer_relocalise();
}

void LaserSlam::refine() { impl_->refine(); }
common::Trajectory2 LaserSlam::final_trajectory() const { return impl_->final_trajectory(); }
common::OccupancyGrid LaserSlam::grid() const { return impl_->grid(); }
common::Result<std::string> LaserSlam::serialize() const { return impl_->serialize(); }
common::Result<void> LaserSlam::restore(const std::string& state) { return impl_->restore(state); }

}  // namespace slamfuse::laser_slam
