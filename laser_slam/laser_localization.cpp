// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/laser_localization.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "laser_slam/beam_model.hpp"
#include "laser_slam/degeneracy.hpp"
#include "laser_slam/frozen_scan.hpp"
#include "laser_slam/hypothesis_filter.hpp"
#include "laser_slam/input_checks.hpp"
#include "laser_slam/likelihood_field.hpp"
#include "laser_slam/localization_monitor.hpp"
#include "laser_slam/localization_path.hpp"
#include "laser_slam/map_state.hpp"
#include "laser_slam/motion_model.hpp"
#include "laser_slam/motion_predictor.hpp"
#include "laser_slam/pose_floor.hpp"
#include "laser_slam/pose_search.hpp"
#include "laser_slam/scan_beams.hpp"
#include "laser_slam/scan_explanation.hpp"
#include "laser_slam/scan_matcher.hpp"
#include "laser_slam/surface_map.hpp"

namespace slamfuse::laser_slam {
namespace {

using common::Pose2;
using common::TrackingState;

constexpr double kCandidateSpread = 0.05;     // [m] of the particles around a pose that was searched for
constexpr double kCandidateTurn = 0.05;       // [rad] the same
constexpr double kStrayDistance = 0.15;       // [m] a pose this far from its particles is matched from them as well
constexpr double kStrayAngle = 0.1;           // [rad] the same
constexpr double kMetresPerRadian = 0.5;      // turning shows as much of a place as driving this far
constexpr double kSearchAgainDistance = 0.2;  // [m] driven while LOST before the whole map is searched once more

Eigen::Matrix3d diagonal(double position, double heading) {
  return Eigen::Vector3d(position * position, position * position, heading * heading).asDiagonal();
}

double distance(const Pose2& a, const Pose2& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// The scan matched at the best hypothesis.
struct Located {
  Pose2 pose;
  ScanFit fit;
  ScanExplanation explanation;
  double agreement = 0.0;
};

}  // namespace

class LaserLocalization::Impl {
 public:
  Impl(const LaserSlamOptions& options, std::string sensor, const common::LaserCalibration& calibration,
       common::OccupancyGrid grid, GridMap surfaces, std::uint64_t seed, std::size_t most_kept)
      : options_(options),
        local_(options.localization),
        sensor_(std::move(sensor)),
        calibration_(calibration),
        mount_(common::to_pose2(calibration.T_base_laser).translation()),
        grid_(std::move(grid)),
        surfaces_(std::move(surfaces)),
        field_(grid_, local_.beam_model.farthest),
        model_(field_, local_.beam_model),
        search_(field_, local_.beam_model, local_.search),
        matcher_(options.matcher, options.evidence_gain(calibration.beams)),
        predictor_(options.motion),
        filter_(local_.filter, seed),
        monitor_(local_.monitor),
        path_(most_kept) {}

  const std::string& sensor() const { return sensor_; }
  const common::OccupancyGrid& grid() const { return grid_; }
  common::Trajectory2 final_trajectory() const { return path_.trajectory(); }

  std::vector<Hypothesis> hypotheses() const {
    std::vector<Hypothesis> result = known_;
    for (Hypothesis& hypothesis : result) {
      hypothesis.mean = hypothesis.mean * moved_;
      hypothesis.best = hypothesis.best * moved_;
    }
    return result;
  }

  void add(const common::WheelOdometry& odometry) {
    predictor_.add(odometry);
    frozen_.moved_to(odometry.pose);
  }

  common::ProcessResult add(const common::LaserScan& scan) {
    if (auto fresh = frozen_.check(scan); !fresh) return {std::nullopt, fresh.error().message};
    common::ProcessResult result;
    const common::Nanoseconds sweep = options_.compensate_sweep ? common::from_seconds(calibration_.sweep_duration) : 0;
    const auto beams = project_scan(scan, calibration_,
                                    {options_.max_range, options_.map.free_beyond_range, options_.matcher.max_beams},
                                    predictor_.begin_sweep(scan.stamp, sweep));
    if (!beams) {
      result.rejected = beams.error().message;
      return result;
    }
    result.estimate = step(scan.stamp, beams->match_points);
    return result;
  }

  void set_pose(const common::SetPose& command) {
    if (const auto usable = check_set_pose(command, pose_floor()); !usable) {
      return announce("set_pose_refused", usable.error().message);
    }
    forget_hypotheses();
    filter_.add({command.pose.x, command.pose.y, common::normalize_angle(command.pose.theta)},
                command.covariance + pose_floor(), 0.0, local_.filter.max_particles);
    known_ = filter_.hypotheses();
    monitor_.trust();
    predictor_.forget_speed();
    announce("relocalised", "the pose was set from outside");
  }

  void relocalise() {
    forget_hypotheses();
    monitor_.lose();
    announce("relocalising", "the pose is searched for in the whole map");
  }

  void reset() {
    ++epoch_;
    path_.clear();
    relocalise();
    announce("map_reset", fmt::format("map epoch {} begins in the same map", epoch_));
  }

 private:
  void announce(std::string kind, std::string detail) {
    pending_.push_back({0, "laser", std::move(kind), std::move(detail)});
  }

  void forget_hypotheses() {
    filter_.clear();
    known_.clear();
    held_since_.clear();
    begin_move();
    followed_.reset();
    last_search_.reset();
  }

  void begin_move() {
    moved_ = {};
    moved_covariance_.setZero();
    moved_travel_ = {};
  }

  common::PoseEstimate step(common::Nanoseconds stamp, const std::vector<Eigen::Vector2d>& points) {
    const MotionPrediction motion = predict(stamp);
    const std::vector<Eigen::Vector2d> few = thin_points(points, local_.beams);
    follow(motion);
    if (update_due()) update(few);
    Located located = locate(points, few);
    if (search_due(stamp, motion, located)) {
      if (look_everywhere(stamp, few, motion, located)) located = locate(points, few);
    }
    predictor_.finish(stamp, motion,
                      monitor_.state() == TrackingState::kTracking && started_ ? last_pose_.inverse() * located.pose
                                                                               : motion.increment);
    last_pose_ = located.pose;
    started_ = true;
    judge(stamp, motion, located);
    return estimate(stamp, located);
  }

  MotionPrediction predict(common::Nanoseconds stamp) {
    if (!started_) predictor_.start(stamp);
    return predictor_.predict(stamp);
  }

  /// Takes the motion to this scan: for the pose at once, for the particles with the next update.
  void follow(const MotionPrediction& motion) {
    Travel travel;
    travel += motion.increment;
    const Eigen::Matrix3d covariance = motion.from_odometry ? odometry_covariance(travel, options_.motion)
                                                            : prediction_covariance(motion.seconds, options_.motion);
    moved_ = moved_ * motion.increment;
    moved_travel_ += motion.increment;
    if (!motion.from_odometry) moved_covariance_ += covariance;
    driven_since_search_ += driven(motion);
    if (!followed_) return;
    pose_ = pose_ * motion.increment;
    covariance_ += to_parent_frame(covariance, pose_);
  }

  static double driven(const MotionPrediction& motion) {
    return std::hypot(motion.increment.x, motion.increment.y) + kMetresPerRadian * std::abs(motion.increment.theta);
  }

  bool update_due() const {
    return !filter_.empty() &&
           (moved_travel_.distance >= local_.update_distance || moved_travel_.turn >= local_.update_angle);
  }

  void update(const std::vector<Eigen::Vector2d>& points) {
    move_particles();
    filter_.weigh(model_, points, mount_);
    known_ = filter_.hypotheses();
  }

  void move_particles() {
    filter_.move(moved_, odometry_covariance(moved_travel_, options_.motion) + moved_covariance_);
    begin_move();
    known_ = filter_.hypotheses();
  }

  /// Matches the scan at the best hypothesis: from where it was followed to, and from its particles when they have
  /// strayed from there or the scan does not agree.
  Located locate(const std::vector<Eigen::Vector2d>& points, const std::vector<Eigen::Vector2d>& few) {
    if (known_.empty()) return {pose_, {}, {}, 0.0};
    const Hypothesis& best = known_.front();
    const Pose2 mean = best.mean * moved_;
    if (followed_ != best.id) {
      followed_ = best.id;
      pose_ = best.best * moved_;
      covariance_ = best.covariance + pose_floor();
    }
    Located located = match_from(pose_, points, few);
    const bool strayed = distance(located.pose, mean) > kStrayDistance ||
                         std::abs(common::angle_difference(located.pose.theta, mean.theta)) > kStrayAngle;
    if (strayed || located.agreement < local_.monitor.good_agreement) {
      for (const Pose2& start : {mean, best.best * moved_}) {
        const Located other = match_from(start, points, few);
        if (other.fit.log_likelihood > located.fit.log_likelihood) located = other;
      }
    }
    pose_ = located.pose;
    const Eigen::Matrix3d information = covariance_.inverse() + matcher_.gain() * located.fit.information;
    covariance_ = information.inverse() + pose_floor();
    return located;
  }

  Located match_from(const Pose2& start, const std::vector<Eigen::Vector2d>& points,
                     const std::vector<Eigen::Vector2d>& few) const {
    const ScanMatch match = matcher_.match(surfaces_, points, start, {start, covariance_.inverse()});
    Located located{match.pose, match.fit, {}, 0.0};
    located.explanation = explain_scan(field_, mount_, few, match.pose, local_.explained_distance);
    located.agreement = located.explanation.agreement(local_.short_weight);
    return located;
  }

  bool search_due(common::Nanoseconds stamp, const MotionPrediction& motion, const Located& located) const {
    if (filter_.empty() || motion.seconds > local_.longest_gap) return true;
    const bool rested = !last_search_ || std::abs(common::to_seconds(stamp - *last_search_)) >= local_.search_interval;
    if (!rested) return false;
    if (located.agreement < local_.monitor.good_agreement) return true;
    return monitor_.state() == TrackingState::kLost && driven_since_search_ >= kSearchAgainDistance;
  }

  /// Searches the whole map and adds the poses nobody thought of as hypotheses. Returns whether there were any.
  bool look_everywhere(common::Nanoseconds stamp, const std::vector<Eigen::Vector2d>& all,
                       const MotionPrediction& motion, const Located& located) {
    const std::vector<Eigen::Vector2d> points = thin_points(all, local_.search.fine_beams);
    last_search_ = stamp;
    driven_since_search_ = 0.0;
    const std::vector<PoseCandidate> candidates = search_.search(points, mount_);
    if (candidates.empty()) return false;
    move_particles();
    const bool first = filter_.empty();
    const double reference =
        first ? candidates.front().log_likelihood : model_.traced_log_likelihood(points, mount_, located.pose);
    // After a long gap the robot may be anywhere as well as where it was.
    const bool doubtful = located.agreement < local_.monitor.good_agreement;
    const double prior = first || motion.seconds > local_.longest_gap ? 1.0
                         : doubtful                                   ? local_.newcomer_prior
                                                                      : 0.5 * (1.0 - local_.monitor.sure_mass);
    const double least = std::log(std::max(local_.filter.least_mass, 1e-300));
    std::vector<std::pair<Pose2, double>> newcomers;  // and their likelihood's logarithm relative to the reference
    double as_likely = 0.0;                           // how many fit as well as it
    for (const PoseCandidate& candidate : candidates) {
      if (is_held(candidate.pose)) continue;
      const double relative = filter_.gain(points.size()) * (candidate.log_likelihood - reference);
      newcomers.emplace_back(candidate.pose, relative);
      as_likely += std::exp(std::min(0.0, relative));
    }
    // They share the prior: a map full of places that look alike makes no place of them more probable.
    const double share = std::log(prior / std::max(1.0, as_likely));
    std::erase_if(newcomers, [&](const auto& newcomer) { return newcomer.second + share < least; });
    const bool any = !newcomers.empty();
    for (const auto& [pose, relative] : newcomers) {
      filter_.add(pose, diagonal(kCandidateSpread, kCandidateTurn), relative + share,
                  std::max(1, local_.filter.max_particles / static_cast<int>(newcomers.size())));
    }
    known_ = filter_.hypotheses();
    std::erase_if(held_since_, [&](const auto& held) { return !is_known(held.first); });
    for (const Hypothesis& hypothesis : known_) held_since_.try_emplace(hypothesis.id, path_.now());
    return any;
  }

  bool is_known(int id) const {
    return std::any_of(known_.begin(), known_.end(), [&](const Hypothesis& hypothesis) { return hypothesis.id == id; });
  }

  bool is_held(const Pose2& pose) const {
    return std::any_of(known_.begin(), known_.end(), [&](const Hypothesis& hypothesis) {
      return distance(pose, hypothesis.mean) < local_.filter.merge_distance &&
             std::abs(common::angle_difference(pose.theta, hypothesis.mean.theta)) < local_.filter.merge_angle;
    });
  }

  void judge(common::Nanoseconds stamp, const MotionPrediction& motion, const Located& located) {
    LocalizationEvidence evidence;
    evidence.stamp = stamp;
    evidence.driven = driven(motion);
    if (!known_.empty()) {
      const Hypothesis& best = known_.front();
      evidence.hypothesis = best.id;
      evidence.agreement = located.agreement;
      evidence.mass = best.mass;
      evidence.spread = std::sqrt(best.covariance.topLeftCorner<2, 2>().trace());
    }
    monitor_.add(evidence);
    const bool good = located.agreement >= local_.monitor.good_agreement;
    path_.add({stamp, located.pose, evidence.hypothesis, good, monitor_.state() != TrackingState::kLost},
              motion.increment);
    if (monitor_.just_lost()) {
      path_.lost();
      announce("lost", fmt::format("the map explains {:.2f} of the scan, the best of {} hypotheses has {:.2f}",
                                   located.agreement, known_.size(), evidence.mass));
    }
    if (monitor_.just_found()) {
      if (const auto since = held_since_.find(evidence.hypothesis); since != held_since_.end()) {
        path_.found_since(since->second);
      }
      announce("relocalised", fmt::format("one hypothesis holds with {:.2f}, the map explains {:.2f} of the scan",
                                          evidence.mass, located.agreement));
    }
  }

  common::PoseEstimate estimate(common::Nanoseconds stamp, const Located& located) {
    common::PoseEstimate estimate;
    estimate.stamp = stamp;
    estimate.source = common::PoseSource::kLaser;
    estimate.map_epoch = epoch_;
    estimate.pose = located.pose;
    estimate.covariance = mixture_covariance(located.pose);
    estimate.state = monitor_.state();
    estimate.health.scan_likelihood = located.agreement;
    if (!known_.empty()) {
      estimate.health.effective_particles = known_.front().effective_particles;
      estimate.health.degenerate_direction = degenerate_direction(located.fit.information, options_.degenerate_ratio);
    }
    for (common::Event& event : pending_) event.stamp = stamp;
    estimate.events = std::exchange(pending_, {});
    return estimate;
  }

  /// Of the matched pose, widened by the other hypotheses as far as they are probable.
  Eigen::Matrix3d mixture_covariance(const Pose2& pose) const {
    Eigen::Matrix3d covariance = covariance_ + pose_floor();
    for (std::size_t i = 1; i < known_.size(); ++i) {
      const Pose2 mean = known_[i].mean * moved_;
      const Eigen::Vector3d offset(mean.x - pose.x, mean.y - pose.y, common::angle_difference(mean.theta, pose.theta));
      covariance += known_[i].mass * (offset * offset.transpose());
    }
    return covariance;
  }

  LaserSlamOptions options_;
  LocalizationOptions local_;
  std::string sensor_;
  common::LaserCalibration calibration_;
  Eigen::Vector2d mount_;  // of the laser in base_link
  common::OccupancyGrid grid_;
  GridMap surfaces_;
  LikelihoodField field_;
  BeamModel model_;
  PoseSearch search_;
  ScanMatcher matcher_;
  MotionPredictor predictor_;
  FrozenScan frozen_;
  HypothesisFilter filter_;
  LocalizationMonitor monitor_;
  LocalizationPath path_;

  bool started_ = false;
  std::uint32_t epoch_ = 0;
  std::vector<Hypothesis> known_;          // of the filter, most probable first, as of the last update
  std::map<int, std::size_t> held_since_;  // hypothesis id -> moment of the path
  std::optional<int> followed_;            // the hypothesis pose_ is about
  Pose2 pose_;                             // T_map_base, matched
  Eigen::Matrix3d covariance_ = diagonal(kCandidateSpread, kCandidateTurn);  // of pose_
  Pose2 last_pose_;                                                          // at the last scan
  std::optional<common::Nanoseconds> last_search_;
  double driven_since_search_ = 0.0;  // [m]
  std::vector<common::Event> pending_;

  // Since the particles were moved last:
  Pose2 moved_;
  Travel moved_travel_;
  Eigen::Matrix3d moved_covariance_ = Eigen::Matrix3d::Zero();  // of what was predicted without odometry
};

LaserLocalization::LaserLocalization(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LaserLocalization::~LaserLocalization() = default;

common::Result<std::unique_ptr<LaserLocalization>> LaserLocalization::create(
    const LaserSlamOptions& options, const std::string& sensor, const common::LaserCalibration& calibration,
    const LocalizationMap& map, std::uint64_t seed, std::size_t most_kept) {
  if (auto checked = check_calibration(sensor, calibration); !checked) return tl::unexpected(checked.error());
  const HypothesisFilterOptions& filter = options.localization.filter;
  if (filter.min_particles > filter.max_particles) {
    return common::invalid_input(
        fmt::format("laser.localization.filter.min_particles is {}; allowed is up to max_particles, which is {}",
                    filter.min_particles, filter.max_particles));
  }
  auto surfaces = surface_map(map.grid, options.map);
  if (!surfaces) return common::invalid_input(map.name + ": " + surfaces.error().message);
  const LikelihoodField field(map.grid, options.localization.beam_model.farthest);
  bool any_free = false;
  bool any_occupied = false;
  for (int row = 0; row < field.height(); ++row) {
    for (int column = 0; column < field.width(); ++column) {
      any_free = any_free || LikelihoodField::is_free(field.code(column, row));
      any_occupied = any_occupied || LikelihoodField::is_occupied(field.code(column, row));
    }
  }
  if (!any_free || !any_occupied) {
    return common::invalid_input(fmt::format("{}: {}x{} cells without any {} one, nothing to localise in", map.name,
                                             map.grid.width, map.grid.height, any_free ? "occupied" : "free"));
  }
  if (!map.laser_state.empty()) {
    auto state = parse_state(map.laser_state, options.map);
    if (!state) return common::invalid_input(map.name + ": " + state.error().message);
    surfaces = std::move(state->map);
  }
  return std::unique_ptr<LaserLocalization>(new LaserLocalization(
      std::make_unique<Impl>(options, sensor, calibration, map.grid, std::move(*surfaces), seed, most_kept)));
}

bool LaserLocalization::wants(const common::SensorMessage& message) const {
  if (std::holds_alternative<common::WheelOdometry>(message)) return true;
  return std::holds_alternative<common::LaserScan>(message) && common::sensor_of(message) == impl_->sensor();
}

common::ProcessResult LaserLocalization::process(const common::SensorMessage& message) {
  if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
    if (const auto usable = check_odometry(*odometry); !usable) return {std::nullopt, usable.error().message};
    impl_->add(*odometry);
    return {};
  }
  if (!wants(message)) return {};
  return impl_->add(std::get<common::LaserScan>(message));
}

void LaserLocalization::execute(const common::Command& command) {
  if (const auto* set_pose = std::get_if<common::SetPose>(&command)) return impl_->set_pose(*set_pose);
  if (std::holds_alternative<common::Reset>(command)) return impl_->reset();
  impl_->relocalise();
}

std::vector<Hypothesis> LaserLocalization::hypotheses() const { return impl_->hypotheses(); }
common::Trajectory2 LaserLocalization::final_trajectory() const { return impl_->final_trajectory(); }
const common::OccupancyGrid& LaserLocalization::grid() const { return impl_->grid(); }

}  // namespace slamfuse::laser_slam
