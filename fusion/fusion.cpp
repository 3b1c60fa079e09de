// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/fusion.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include "common/odometry_buffer.hpp"
#include "common/thinned_history.hpp"
#include "fusion/alignment_keeper.hpp"
#include "fusion/carry_watch.hpp"
#include "fusion/corrected_pose_filter.hpp"
#include "fusion/correction_limiter.hpp"
#include "fusion/credibility.hpp"
#include "fusion/final_path.hpp"
#include "fusion/frame_bridge.hpp"
#include "fusion/measurement_model.hpp"
#include "fusion/motion_check.hpp"
#include "fusion/odometry_clock.hpp"
#include "fusion/source_monitor.hpp"
#include "fusion/status_log.hpp"

namespace slamfuse::fusion {

using common::Nanoseconds;
using common::PoseEstimate;
using common::PoseSource;
using common::TrackingState;

namespace {

/// Published poses this far [m] behind the filter are called suspect.
constexpr double kSuspectLag = 0.3;

/// Where odometry stood at a time, and for how long before it there was none.
struct OdometryAt {
  common::Pose2 T_odom_base;
  double seconds_without = 0.0;
};

double position_sigma(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix2d position = covariance.topLeftCorner<2, 2>();
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(position).eigenvalues().maxCoeff());
}

VisualScale scale_of(const FusionOptions& options) {
  return options.supervision.visual_scale_drifts ? VisualScale::kUnknown : VisualScale::kMetric;
}

}  // namespace

struct Fusion::State {
  State(const FusionOptions& given, std::size_t most_kept)
      : options(given),
        keeper(given.alignment, given.schedule, scale_of(given), most_kept),
        filter(given.filter),
        limiter(given.limit),
        monitors{{PoseSource::kLaser, SourceMonitor(PoseSource::kLaser, given.monitor)},
                 {PoseSource::kVisual, SourceMonitor(PoseSource::kVisual, given.monitor)}},
        motions{{PoseSource::kLaser, MotionCheck(given.motion, given.filter.drift)},
                {PoseSource::kVisual, MotionCheck(given.motion, given.filter.drift)}},
        carry(given.supervision, given.monitor.silent_after),
        status(common::from_seconds(given.supervision.status_interval)),
        published(most_kept),
        received(most_kept) {}

  void tell(FusionOutput& output, std::string kind, std::string detail) const {
    output.events.push_back({now, "fusion", std::move(kind), std::move(detail)});
  }
  /// Nothing when the stamp is older than all odometry still known.
  std::optional<OdometryAt> odometry_at(Nanoseconds stamp) const;
  /// Until odometry speaks the robot counts as standing at the origin of its frame; that origin is now known to be
  /// where odometry starts, for all that was kept too.
  void start_odometry_at(const common::Pose2& T_odom_base);
  /// Takes notice of the epoch. Returns false for poses of an epoch that is over.
  bool accept_epoch(const PoseEstimate& estimate, FusionOutput& output);
  /// How the halves moved and how their poses fitted was judged in maps or frames that do not hold any more.
  void forget_fits();
  /// Nothing is known of the corrected pose any more.
  void restart_pose();
  /// Whose frame the corrected pose is in, decided as halves speak up.
  void choose_map_frame(const PoseEstimate& estimate, FusionOutput& output);
  /// The estimate in the map frame; nothing while there is no way from its frame to that.
  std::optional<UncertainPose> in_map_frame(const PoseEstimate& estimate);
  /// From now on; the corrected pose stays where it is.
  void use_alignment(const std::optional<Alignment>& alignment);
  /// The estimate with its stamp by the laser's clock, as far as the alignment tells.
  PoseEstimate by_laser_clock(PoseEstimate estimate) const;
  /// Lets go of visual poses whose time has come by the laser's clock.
  void use_waiting(FusionOutput& output);
  /// Collects it for the alignment (by its own clock) and uses it now, or when odometry has come to its time.
  void take(const PoseEstimate& estimate, FusionOutput& output);
  void use(const PoseEstimate& estimate, FusionOutput& output);
  /// Takes notice of where the half says it is, and tells whether it does not move as the wheels do although the other
  /// one does.
  bool moves_unlike_the_rest(const PoseEstimate& estimate, const common::Pose2& T_odom_base);
  /// Whether the half was told its pose of late by the other one, which still tracks.
  bool is_on_probation(PoseSource half) const;
  /// Odometry has come to `stamp`: times that do not count are taken out of what was said before.
  void follow_clock(Nanoseconds stamp);
  void align_if_due(FusionOutput& output);
  void report(const Alignment& attempt, FusionOutput& output);
  /// Tells once, and again when it has changed, what lies between the sensors although the configuration says nothing
  /// does.
  void warn_of_offsets(const Alignment& attempt, FusionOutput& output);
  /// After a carry what was known of the pose is void, until a half says where it is.
  void give_up_if_carried();
  StatusEntry fused_status() const;
  void command_lost_halves(FusionOutput& output);
  void write_status(FusionOutput& output);
  void publish(FusionOutput& output);

  FusionOptions options;
  common::OdometryBuffer odometry;
  AlignmentKeeper keeper;
  FrameBridge bridge;
  CorrectedPoseFilter filter;
  CorrectionLimiter limiter;
  Credibility credibility;
  SourceMonitors monitors;
  std::map<PoseSource, MotionCheck> motions;
  CarryWatch carry;
  StatusLog status;
  std::map<PoseSource, std::uint32_t> epochs;
  std::map<PoseSource, Nanoseconds> last_command;
  std::map<PoseSource, Nanoseconds> probation_since;  ///< when it was told its pose
  std::optional<PoseSource> map_frame;
  std::optional<Nanoseconds> first_visual;
  std::deque<PoseEstimate> waiting;  ///< visual poses from ahead of odometry by the laser's clock
  double warned_clock_offset = 0.0;
  Eigen::Vector2d warned_lever_arm = Eigen::Vector2d::Zero();
  Nanoseconds now = 0;  ///< where the filter stands
  OdometryClock clock;
  Nanoseconds last_used = 0;  ///< stamp of the last measurement that was used
  bool was_lost = true;
  common::ThinnedHistory<PublishedPose> published;
  common::ThinnedHistory<ReceivedEstimate> received;
};

std::optional<OdometryAt> Fusion::State::odometry_at(Nanoseconds stamp) const {
  if (odometry.empty()) return OdometryAt{{}, std::abs(common::to_seconds(stamp - now))};
  if (const auto pose = odometry.pose_at(stamp)) return OdometryAt{*pose, 0.0};
  const common::WheelOdometry& newest = odometry.newest();
  if (stamp < newest.stamp) return std::nullopt;
  return OdometryAt{newest.pose, std::abs(common::to_seconds(stamp - std::max(now, newest.stamp)))};
}

void Fusion::State::start_odometry_at(const common::Pose2& T_odom_base) {
  filter.change_odometry_frame(T_odom_base);
  limiter.change_odometry_frame(T_odom_base);
  for (PublishedPose& pose : published.changeable()) pose.T_odom_base = T_odom_base * pose.T_odom_base;
  for (ReceivedEstimate& estimate : received.changeable()) estimate.T_odom_base = T_odom_base * estimate.T_odom_base;
}

bool Fusion::State::accept_epoch(const PoseEstimate& estimate, FusionOutput& output) {
  const auto [known, first] = epochs.try_emplace(estimate.source, estimate.map_epoch);
  if (first || known->second == estimate.map_epoch) return true;
  if (estimate.map_epoch < known->second) return false;
  known->second = estimate.map_epoch;
  keeper.forget(estimate.source);
  use_alignment(std::nullopt);
  bridge.forget_place();
  filter.forget(estimate.source);
  forget_fits();
  waiting.clear();
  carry.forget(estimate.source);
  if (map_frame == estimate.source) {
    restart_pose();
    carry.restart();
  }
  tell(output, "map_reset",
       fmt::format("the {} map started epoch {}: its pairs and the alignment are void",
                   common::to_string(estimate.source), estimate.map_epoch));
  return true;
}

void Fusion::State::forget_fits() {
  for (auto& [source, motion] : motions) motion.forget();
  for (auto& [source, monitor] : monitors) monitor.forget_fit();
  probation_since.clear();
}

void Fusion::State::restart_pose() {
  filter.restart();
  limiter.restart();
}

void Fusion::State::choose_map_frame(const PoseEstimate& estimate, FusionOutput& output) {
  if (estimate.source == PoseSource::kLaser) {
    if (map_frame == PoseSource::kVisual) {
      restart_pose();
      carry.restart();
      forget_fits();
      tell(output, "frame_changed", "the laser half has come: the map frame is the laser's from now on");
    }
    map_frame = PoseSource::kLaser;
    return;
  }
  // A laser that searches its place in a map speaks, too: its frame is waited for.
  const SourceMonitor& laser = monitors.at(PoseSource::kLaser);
  if (laser.heard() && common::to_seconds(now - laser.last_stamp()) < options.supervision.visual_only_after) return;
  if (!first_visual) first_visual = estimate.stamp;
  const double waited = common::to_seconds(estimate.stamp - *first_visual);
  if (!map_frame && waited >= options.supervision.visual_only_after) map_frame = PoseSource::kVisual;
}

void Fusion::State::use_alignment(const std::optional<Alignment>& alignment) {
  if (const auto step = bridge.use(alignment)) filter.shift(PoseSource::kVisual, *step);
}

std::optional<UncertainPose> Fusion::State::in_map_frame(const PoseEstimate& estimate) {
  const UncertainPose measured = measurement_of(estimate, options.measurement);
  if (map_frame == estimate.source) return measured;
  if (map_frame == PoseSource::kLaser) return bridge.to_laser(measured);
  return std::nullopt;
}

PoseEstimate Fusion::State::by_laser_clock(PoseEstimate estimate) const {
  if (estimate.source == PoseSource::kVisual && map_frame != PoseSource::kVisual && keeper.accepted()) {
    estimate.stamp += common::from_seconds(keeper.accepted()->clock_offset);
  }
  return estimate;
}

void Fusion::State::use_waiting(FusionOutput& output) {
  while (!waiting.empty() && waiting.front().stamp <= now) {
    const PoseEstimate estimate = waiting.front();
    waiting.pop_front();
    use(estimate, output);
  }
}

void Fusion::State::take(const PoseEstimate& estimate, FusionOutput& output) {
  choose_map_frame(estimate, output);
  keeper.add(estimate);
  align_if_due(output);
  const PoseEstimate timed = by_laser_clock(estimate);
  if (timed.stamp > estimate.stamp && timed.stamp > now) {
    waiting.push_back(timed);
  } else {
    use(timed, output);
  }
}

void Fusion::State::use(const PoseEstimate& estimate, FusionOutput& output) {
  const auto then = odometry_at(estimate.stamp);
  if (!then) return;
  if (!carry.may_start(estimate, monitors, now)) return;
  const auto measured = in_map_frame(estimate);
  if (!measured) return;

  const bool late = estimate.stamp < now;
  if (!late) {
    filter.move_to(then->T_odom_base, then->seconds_without);
    now = estimate.stamp;
  }
  const bool moves_otherwise = !odometry.empty() && moves_unlike_the_rest(estimate, then->T_odom_base);
  const MeasurementReport report =
      moves_otherwise ? MeasurementReport{MeasurementOutcome::kOverruled, 0.0, 0.0}
                      : filter.measure(estimate.source, estimate.stamp, *measured, then->T_odom_base,
                                       late ? then->seconds_without : 0.0, is_on_probation(estimate.source));
  monitors.at(estimate.source).measured(report, moves_otherwise);
  if (!moves_otherwise) carry.found(estimate);
  if (report.outcome == MeasurementOutcome::kAdopted) {
    tell(output, "raw_jump",
         fmt::format("the {} half told another place long enough: the corrected pose moves {:.2f} m",
                     common::to_string(estimate.source), report.jump));
  }
  const common::Pose2 measured_now = measured->pose * (then->T_odom_base.inverse() * filter.T_odom_base());
  // A pose that is held back agrees all the same that the robot is where it is believed to be.
  carry.measured(estimate, filter.state().pose.inverse() * measured_now, report.fits());
  if (!report.used()) return;
  // A late pose does not undo a newer one; where the clock itself steps back (CARMEN) nothing is late.
  last_used = late ? std::max(last_used, estimate.stamp) : estimate.stamp;
}

bool Fusion::State::moves_unlike_the_rest(const PoseEstimate& estimate, const common::Pose2& T_odom_base) {
  const bool is_metric = estimate.source == PoseSource::kLaser || !options.supervision.visual_scale_drifts;
  const auto scale = estimate.source == PoseSource::kVisual ? bridge.scale() : std::optional(1.0);
  if (!scale && !is_metric) return false;
  UncertainPose told = measurement_of(estimate, options.measurement);
  told.covariance *= options.filter.map_error.random_share;
  MotionCheck& own = motions.at(estimate.source);
  own.add(estimate.stamp, told, scale.value_or(1.0), T_odom_base);
  const PoseSource other = other_half(estimate.source);
  return filter.started() && own.plausible(now) == false && motions.at(other).confirms(now) &&
         monitors.at(other).healthy(now);
}

bool Fusion::State::is_on_probation(PoseSource half) const {
  const auto told = probation_since.find(half);
  if (told == probation_since.end() || common::to_seconds(now - told->second) >= options.supervision.probation) {
    return false;
  }
  const SourceMonitor& other = monitors.at(other_half(half));
  return other.speaks(now) && other.own_state() == TrackingState::kTracking && !other.overruled();
}

void Fusion::State::follow_clock(Nanoseconds stamp) {
  const Nanoseconds shift = clock.next(stamp);
  if (shift == 0) return;
  last_used += shift;
  carry.shift(shift);
  for (auto& [source, monitor] : monitors) monitor.shift(shift);
  for (auto* told_at : {&last_command, &probation_since}) {
    for (auto& [source, told] : *told_at) told += shift;
  }
}

void Fusion::State::align_if_due(FusionOutput& output) {
  const auto attempt = keeper.update();
  if (!attempt) return;
  report(*attempt, output);
  use_alignment(keeper.accepted());
}

void Fusion::State::warn_of_offsets(const Alignment& attempt, FusionOutput& output) {
  if (!attempt.offsets) return;
  const bool clock_changed =
      std::abs(attempt.clock_offset - warned_clock_offset) > options.alignment.offsets.smallest_clock_offset;
  const bool lever_changed =
      (attempt.lever_arm - warned_lever_arm).norm() > options.alignment.offsets.smallest_lever_arm;
  if (!clock_changed && !lever_changed) return;
  warned_clock_offset = attempt.clock_offset;
  warned_lever_arm = attempt.lever_arm;
  tell(output, "sensor_offsets",
       fmt::format(
           "the poses disagree with stamps and mountings as configured: {}; used: {:.1f} ms, ({:.3f}, {:.3f}) m",
           describe(*attempt.offsets), 1e3 * attempt.clock_offset, attempt.lever_arm.x(), attempt.lever_arm.y()));
}

void Fusion::State::report(const Alignment& attempt, FusionOutput& output) {
  if (attempt.accepted) warn_of_offsets(attempt, output);
  tell(output, attempt.accepted ? "aligned" : "alignment_refused",
       fmt::format("{}: {}; rotation {:.2f} deg, scale {:.4f} x {:.4f}", to_string(attempt.method), attempt.reason,
                   attempt.rotation_deg, attempt.scale.x(), attempt.scale.y()));
}

void Fusion::State::give_up_if_carried() {
  if (!filter.started() || !carry.carried(monitors, now)) return;
  carry.give_up(monitors, now);
  restart_pose();
  bridge.forget_place();
  for (auto& [source, motion] : motions) motion.forget();
  probation_since.clear();
}

StatusEntry Fusion::State::fused_status() const {
  StatusEntry entry;
  entry.stamp = now;
  entry.source = PoseSource::kFused;
  if (!filter.started()) {
    entry.state = Verdict::kLost;
    entry.score = 0.0;
    entry.reasons.emplace_back(carry.gave_up() ? "the halves say they are lost or somewhere else"
                                               : "no usable pose has come yet");
    return entry;
  }
  entry.score = 0.0;
  for (const auto& [source, monitor] : monitors) {
    if (monitor.heard()) entry.score = std::max(entry.score, monitor.status(now).score);
  }
  carry.judge(monitors, now, entry);
  const double silence = common::to_seconds(now - last_used);
  const bool confirmed = silence < options.monitor.silent_after;
  if (!confirmed) {
    if (entry.state == Verdict::kTracking) entry.state = Verdict::kSuspect;
    entry.score *= 0.5;
    entry.reasons.push_back(fmt::format("neither half confirms it for {:.1f} s, odometry alone", silence));
    const Eigen::Matrix3d& covariance = filter.state().covariance;
    const double position = position_sigma(covariance);
    const double heading = std::sqrt(covariance(2, 2));
    if (position > options.supervision.lost_position_sigma || heading > options.supervision.lost_heading_sigma) {
      entry.state = Verdict::kLost;
      entry.score = 0.0;
      entry.reasons.push_back(fmt::format("odometry has drifted to {:.2f} m and {:.2f} rad", position, heading));
    }
  }
  if (entry.state == Verdict::kTracking && limiter.lag() > kSuspectLag) {
    entry.state = Verdict::kSuspect;
    entry.reasons.push_back(fmt::format("a correction of {:.2f} m is still under way", limiter.lag()));
  }
  return entry;
}

/// A half that is lost, or that the other half contradicts, is told where it is.
void Fusion::State::command_lost_halves(FusionOutput& output) {
  if (map_frame != PoseSource::kLaser || !keeper.accepted() || !filter.started()) return;
  for (const PoseSource target : {PoseSource::kLaser, PoseSource::kVisual}) {
    const SourceMonitor& monitor = monitors.at(target);
    const bool bent = target == PoseSource::kVisual && options.supervision.visual_scale_drifts;
    const bool contradicted = !bent && monitor.overruled_for(now) >= options.supervision.contradiction_time;
    const bool lost = monitor.lost_for(now).value_or(0.0) >= options.supervision.help_after;
    const bool in_need = monitor.heard() && (lost || contradicted);
    if (!in_need || !monitors.at(other_half(target)).healthy(now)) continue;
    const auto last = last_command.find(target);
    if (last != last_command.end() && common::to_seconds(now - last->second) < options.supervision.command_interval) {
      continue;
    }
    last_command[target] = now;
    // A bent map is no better witness than a laser that was lost.
    if (!options.supervision.visual_scale_drifts) probation_since[target] = now;
    probation_since.erase(other_half(target));
    motions.at(target).forget();
    monitors.at(target).forget_fit();
    const UncertainPose expected = filter.expected(target);
    const UncertainPose pose =
        target == PoseSource::kLaser ? expected : *bridge.to_visual(expected, filter.knows(target));
    output.commands.push_back({target, common::SetPose{pose.pose, pose.covariance}});
    tell(output, "set_pose", fmt::format("the {} half is told its pose", common::to_string(target)));
  }
}

void Fusion::State::write_status(FusionOutput& output) {
  for (const auto& [source, monitor] : monitors) {
    if (monitor.heard()) status.write(monitor.status(now), output.status);
  }
}

void Fusion::State::publish(FusionOutput& output) {
  std::optional<UncertainPose> pose;
  if (filter.started()) {
    // Without odometry nothing tells the robot's own motion from a correction, and none may be held back.
    if (odometry.empty()) limiter.restart();
    pose = limiter.follow(now, filter.state(), filter.T_odom_base());
  }
  const StatusEntry verdict = fused_status();
  status.write(verdict, output.status);
  const bool lost = verdict.state == Verdict::kLost;
  if (lost != was_lost) {
    tell(output, lost ? "lost" : "tracking", lost ? verdict.reasons.back() : "the corrected pose is available");
  }
  was_lost = lost;
  if (lost) {
    limiter.restart();
    return;
  }
  CorrectedPose corrected;
  corrected.estimate.stamp = now;
  corrected.estimate.source = PoseSource::kFused;
  corrected.estimate.map_epoch = epochs[*map_frame];
  corrected.estimate.pose = pose->pose;
  corrected.estimate.covariance = pose->covariance;
  corrected.estimate.state = verdict.state == Verdict::kSuspect ? TrackingState::kUncertain : TrackingState::kTracking;
  corrected.T_map_odom = pose->pose * filter.T_odom_base().inverse();
  output.pose = corrected;
  published.push({now, filter.T_odom_base(), published.count()});
}

common::Result<std::unique_ptr<Fusion>> Fusion::create(const FusionOptions& options, std::size_t most_kept) {
  const double steps = 90.0 / options.alignment.seed004.angle_step;
  if (!(std::abs(steps - std::round(steps)) < 1e-9) || steps < 1.0) {
    return common::invalid_input(fmt::format("fusion.alignment.seed004.angle_step: {} does not divide 90 degrees",
                                             options.alignment.seed004.angle_step));
  }
  return std::unique_ptr<Fusion>(new Fusion(options, most_kept));
}

Fusion::Fusion(const FusionOptions& options, std::size_t most_kept)
    : state_(std::make_unique<State>(options, most_kept)) {}
Fusion::~Fusion() = default;

FusionOutput Fusion::process(const common::WheelOdometry& odometry) {
  FusionOutput output;
  if (!odometry.pose.is_finite() || !std::isfinite(odometry.forward_speed) || !std::isfinite(odometry.turn_rate)) {
    output.rejected = "the odometry message has a number that is not finite";
    return output;
  }
  State& s = *state_;
  const bool first = s.odometry.empty();
  s.odometry.add(odometry);
  if (first) s.start_odometry_at(odometry.pose);
  s.follow_clock(odometry.stamp);
  s.filter.move_to(odometry.pose, 0.0);
  s.now = odometry.stamp;
  s.use_waiting(output);
  s.give_up_if_carried();
  s.command_lost_halves(output);
  s.write_status(output);
  s.publish(output);
  return output;
}

FusionOutput Fusion::process(const PoseEstimate& told) {
  FusionOutput output;
  State& s = *state_;
  output.rejected = flaw_of(told);
  if (output.rejected) return output;
  if (!s.accept_epoch(told, output)) {
    output.rejected = fmt::format("the pose is of map epoch {}, which is over", told.map_epoch);
    return output;
  }
  PoseEstimate estimate = told;
  estimate.state = s.credibility.of(told);
  if (s.odometry.empty() && !s.filter.started()) s.now = estimate.stamp;
  s.use_waiting(output);
  const bool late = estimate.stamp < s.now;
  s.clock.heard(estimate.stamp);
  SourceMonitor& monitor = s.monitors.at(estimate.source);
  s.carry.estimated(estimate, s.by_laser_clock(estimate).stamp, monitor, s.filter.started());
  monitor.estimated(estimate);
  const auto& published = s.published.items();
  const auto before = std::find_if(published.rbegin(), published.rend(),
                                   [&](const PublishedPose& pose) { return pose.stamp < estimate.stamp; });
  const std::size_t place = before == published.rend() ? 0 : before->number + 1;
  const auto odometry = s.odometry_at(s.by_laser_clock(estimate).stamp);
  s.received.push({estimate.stamp, estimate.source, estimate.state,
                   odometry ? odometry->T_odom_base : s.filter.T_odom_base(), late ? place : s.published.count()});
  const bool usable = estimate.state != TrackingState::kLost;
  if (usable) s.take(estimate, output);
  s.give_up_if_carried();
  s.command_lost_halves(output);
  s.write_status(output);
  if (usable && s.now == estimate.stamp && !late) s.publish(output);
  return output;
}

void Fusion::assume(const Alignment& alignment) {
  state_->keeper.assume(alignment);
  state_->use_alignment(state_->keeper.accepted());
}

FusionOutput Fusion::align_now() {
  FusionOutput output;
  state_->report(state_->keeper.align(), output);
  state_->use_alignment(state_->keeper.accepted());
  return output;
}

FusionResult Fusion::finish(const common::Trajectory2& laser_final, const common::Trajectory2& visual_final) {
  State& s = *state_;
  const auto laser = anchors_of(laser_final, PoseSource::kLaser, s.received.items());
  const auto visual = anchors_of(visual_final, PoseSource::kVisual, s.received.items());
  FusionResult result;
  result.alignment = align_trajectories(path_of(laser), path_of(visual), s.options.alignment, scale_of(s.options));
  if (!result.alignment.accepted && s.keeper.assumed()) result.alignment = *s.keeper.assumed();

  std::vector<PathAnchor> anchors = laser;
  if (s.map_frame == PoseSource::kVisual) {
    anchors = visual;
  } else if (result.alignment.accepted) {
    std::vector<PathAnchor> mapped = visual;
    for (PathAnchor& anchor : mapped) {
      anchor.stamp += common::from_seconds(result.alignment.clock_offset);
      anchor.T_map_base = result.alignment.to_laser(anchor.T_map_base);
    }
    anchors = fill_gaps(laser, mapped, common::from_seconds(s.options.monitor.silent_after));
  }
  result.fused_final = smooth_path(s.published.items(), anchors);
  FusionOutput told;
  s.report(result.alignment, told);
  result.events = std::move(told.events);
  return result;
}

const std::optional<Alignment>& Fusion::alignment() const {
  return state_->keeper.accepted() ? state_->keeper.accepted() : state_->keeper.last();
}

PoseSource Fusion::map_frame() const { return state_->map_frame.value_or(PoseSource::kLaser); }

}  // namespace slamfuse::fusion
