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
#include "fusion/alignment_keeper.hpp"
#include "fusion/corrected_pose_filter.hpp"
#include "fusion/correction_limiter.hpp"
#include "fusion/final_path.hpp"
#include "fusion/frame_bridge.hpp"
#include "fusion/measurement_model.hpp"
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

PoseSource other_half(PoseSource source) {
  return source == PoseSource::kLaser ? PoseSource::kVisual : PoseSource::kLaser;
}

}  // namespace

struct Fusion::State {
  explicit State(const FusionOptions& given)
      : options(given),
        keeper(given.alignment, given.schedule),
        bridge(given.bend, given.filter.drift),
        filter(given.filter),
        limiter(given.limit),
        monitors{{PoseSource::kLaser, SourceMonitor(PoseSource::kLaser, given.monitor)},
                 {PoseSource::kVisual, SourceMonitor(PoseSource::kVisual, given.monitor)}},
        status(common::from_seconds(given.supervision.status_interval)) {}

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
  /// Whose frame the corrected pose is in, decided as halves speak up.
  void choose_map_frame(const PoseEstimate& estimate, FusionOutput& output);
  /// The estimate in the map frame; nothing while there is no way from its frame to that.
  std::optional<UncertainPose> in_map_frame(const PoseEstimate& estimate, const common::Pose2& T_odom_base);
  /// The estimate with its stamp by the laser's clock, as far as the alignment tells.
  PoseEstimate by_laser_clock(PoseEstimate estimate) const;
  /// Lets go of visual poses whose time has come by the laser's clock.
  void use_waiting(FusionOutput& output);
  /// Collects it for the alignment (by its own clock) and uses it now, or when odometry has come to its time.
  void take(const PoseEstimate& estimate, FusionOutput& output);
  void use(const PoseEstimate& estimate, FusionOutput& output);
  void align_if_due(FusionOutput& output);
  void report(const Alignment& attempt, FusionOutput& output);
  /// Tells once, and again when it has changed, what lies between the sensors although the configuration says nothing
  /// does.
  void warn_of_offsets(const Alignment& attempt, FusionOutput& output);
  /// For how long [s] every half that speaks has called itself lost; nothing while one does not, or none speaks.
  std::optional<double> all_lost_for() const;
  /// A half speaks; notes the end of a silence of both.
  void hear(Nanoseconds stamp);
  /// One half has stopped tracking: until the other one, tracking, confirms the fused pose, nobody vouches for it.
  void take_doubt(const PoseEstimate& estimate);
  /// A pose in the map frame was measured and used or not: that settles the doubt, deepens it, or leaves it.
  void weigh_doubt(const PoseEstimate& estimate, const common::Pose2& measured, bool used);
  /// Every half says it is lost, or has found itself elsewhere, as after a carry: what was known of the pose is void,
  /// until one says where it is.
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
  std::map<PoseSource, SourceMonitor> monitors;
  StatusLog status;
  std::map<PoseSource, std::uint32_t> epochs;
  std::map<PoseSource, Nanoseconds> last_command;
  std::optional<PoseSource> map_frame;
  std::optional<Nanoseconds> first_visual;
  std::deque<PoseEstimate> waiting;  ///< visual poses from ahead of odometry by the laser's clock
  double warned_clock_offset = 0.0;
  Eigen::Vector2d warned_lever_arm = Eigen::Vector2d::Zero();
  Nanoseconds now = 0;        ///< where the filter stands
  Nanoseconds last_used = 0;  ///< stamp of the last measurement that was used
  bool was_lost = true;
  /// Of the fused pose, since a half stopped tracking.
  struct Doubt {
    Nanoseconds since = 0;
    bool lost = false;                           ///< it has called itself lost
    std::optional<Nanoseconds> elsewhere_since;  ///< and then found itself somewhere else
  };
  std::map<PoseSource, Doubt> doubts;       ///< by the half they come from
  std::optional<Nanoseconds> heard_at;      ///< stamp of the newest estimate of either half
  std::optional<Nanoseconds> silent_until;  ///< when the last silence of both halves ended
  bool gave_up = false;                     ///< the pose is void because of a carry
  std::optional<PoseSource> found_by;       ///< the half whose word counts then, having noticed it
  std::vector<PublishedPose> published;
  std::vector<ReceivedEstimate> received;
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
  bridge.change_odometry_frame(T_odom_base);
  for (PublishedPose& pose : published) pose.T_odom_base = T_odom_base * pose.T_odom_base;
  for (ReceivedEstimate& estimate : received) estimate.T_odom_base = T_odom_base * estimate.T_odom_base;
}

bool Fusion::State::accept_epoch(const PoseEstimate& estimate, FusionOutput& output) {
  const auto [known, first] = epochs.try_emplace(estimate.source, estimate.map_epoch);
  if (first || known->second == estimate.map_epoch) return true;
  if (estimate.map_epoch < known->second) return false;
  known->second = estimate.map_epoch;
  keeper.forget(estimate.source);
  bridge.use(std::nullopt);
  waiting.clear();
  doubts.erase(estimate.source);
  found_by.reset();
  if (map_frame == estimate.source) {
    filter.restart();
    limiter.restart();
    doubts.clear();
    gave_up = false;
    silent_until.reset();
  }
  tell(output, "map_reset",
       fmt::format("the {} map started epoch {}: its pairs and the alignment are void",
                   common::to_string(estimate.source), estimate.map_epoch));
  return true;
}

void Fusion::State::choose_map_frame(const PoseEstimate& estimate, FusionOutput& output) {
  if (estimate.source == PoseSource::kLaser) {
    if (map_frame == PoseSource::kVisual) {
      filter.restart();
      limiter.restart();
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

std::optional<UncertainPose> Fusion::State::in_map_frame(const PoseEstimate& estimate,
                                                         const common::Pose2& T_odom_base) {
  const UncertainPose measured = measurement_of(estimate, options.measurement);
  if (map_frame == estimate.source) return measured;
  if (map_frame == PoseSource::kLaser)
    return bridge.to_laser(estimate.stamp, measured, T_odom_base, options.filter.gate);
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
  // After a carry a half that only guesses where it might be must not be the one to say so, nor one that has not
  // noticed.
  if (gave_up && estimate.state != TrackingState::kTracking) return;
  if (gave_up && found_by && estimate.source != *found_by && monitors.at(*found_by).speaks(now)) return;
  const auto measured = in_map_frame(estimate, then->T_odom_base);
  if (!measured) return;

  const bool late = estimate.stamp < now;
  if (!late) {
    filter.move_to(then->T_odom_base, then->seconds_without);
    now = estimate.stamp;
  }
  const MeasurementReport report =
      filter.measure(estimate.source, estimate.stamp, *measured, then->T_odom_base, late ? then->seconds_without : 0.0);
  monitors.at(estimate.source).measured(report);
  gave_up = false;
  if (report.outcome == MeasurementOutcome::kAdopted) {
    tell(output, "raw_jump",
         fmt::format("the {} half told another place long enough: the corrected pose moves {:.2f} m",
                     common::to_string(estimate.source), report.jump));
  }
  const bool used = report.outcome != MeasurementOutcome::kGated && report.outcome != MeasurementOutcome::kOverruled;
  weigh_doubt(estimate, measured->pose * (then->T_odom_base.inverse() * filter.T_odom_base()), used);
  if (!used) return;
  // A late pose does not undo a newer one; where the clock itself steps back (CARMEN) nothing is late.
  last_used = late ? std::max(last_used, estimate.stamp) : estimate.stamp;
  if (estimate.source == PoseSource::kLaser) bridge.laser_told(estimate.stamp, *measured, then->T_odom_base);
}

void Fusion::State::align_if_due(FusionOutput& output) {
  const auto attempt = keeper.update();
  if (!attempt) return;
  report(*attempt, output);
  bridge.use(keeper.accepted());
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

std::optional<double> Fusion::State::all_lost_for() const {
  std::optional<double> shortest;
  for (const auto& [source, monitor] : monitors) {
    if (!monitor.speaks(now)) continue;
    const auto lost = monitor.lost_for(now);
    if (!lost) return std::nullopt;
    shortest = std::min(*lost, shortest.value_or(*lost));
  }
  return shortest;
}

void Fusion::State::hear(Nanoseconds stamp) {
  const bool silent = heard_at && common::to_seconds(stamp - *heard_at) >= options.monitor.silent_after;
  if (silent && filter.started()) silent_until = stamp;
  heard_at = std::max(heard_at.value_or(stamp), stamp);  // poses come late, too
}

void Fusion::State::take_doubt(const PoseEstimate& estimate) {
  const SourceMonitor& monitor = monitors.at(estimate.source);
  const auto before = monitor.heard() ? monitor.own_state() : TrackingState::kLost;
  const bool stops = before == TrackingState::kTracking && estimate.state != TrackingState::kTracking;
  const bool is_lost_now = before != TrackingState::kLost && estimate.state == TrackingState::kLost;
  if (stops || is_lost_now)
    doubts.try_emplace(estimate.source, Doubt{by_laser_clock(estimate).stamp, false, std::nullopt});
  if (estimate.state != TrackingState::kTracking) found_by.reset();
  const auto doubt = doubts.find(estimate.source);
  if (doubt == doubts.end()) return;
  if (estimate.state == TrackingState::kLost) {
    doubt->second.lost = true;
    doubt->second.elsewhere_since.reset();
  }
  if (estimate.state == TrackingState::kTracking && !doubt->second.lost) doubts.erase(doubt);
}

void Fusion::State::weigh_doubt(const PoseEstimate& estimate, const common::Pose2& measured, bool used) {
  if (estimate.state != TrackingState::kTracking) return;
  if (const auto own = doubts.find(estimate.source); own != doubts.end()) {
    const bool bent = estimate.source == PoseSource::kVisual && options.supervision.visual_scale_drifts;
    const common::Pose2 off = filter.state().pose.inverse() * measured;
    const bool far = off.translation().norm() > options.supervision.lost_position_sigma ||
                     std::abs(off.theta) > options.supervision.lost_heading_sigma;
    if (used || bent || !far) own->second.elsewhere_since.reset();
    if (!used && far && !bent && !own->second.elsewhere_since) own->second.elsewhere_since = estimate.stamp;
    if (used) doubts.erase(own);
  }
  const auto other = doubts.find(other_half(estimate.source));
  if (other == doubts.end() || !used) return;
  // After a carry the other half may take a moment longer to notice, and vouches for nothing until then. (Clocks that
  // step back do not keep it waiting.)
  const Doubt& doubt = other->second;
  const double patience =
      doubt.elsewhere_since ? options.supervision.contradiction_time : options.supervision.help_after;
  const Nanoseconds begun = doubt.elsewhere_since.value_or(doubt.since);
  if (std::abs(common::to_seconds(estimate.stamp - begun)) >= patience) doubts.erase(other);
}

void Fusion::State::give_up_if_carried() {
  if (!filter.started()) return;
  const auto lost = all_lost_for();
  const bool all_lost = lost && *lost >= options.supervision.both_lost_after;
  const auto elsewhere = std::find_if(doubts.begin(), doubts.end(), [this](const auto& doubt) {
    return doubt.second.elsewhere_since && !monitors.at(other_half(doubt.first)).healthy(now);
  });
  if (!all_lost && elsewhere == doubts.end()) return;
  found_by = elsewhere == doubts.end() ? std::nullopt : std::optional(elsewhere->first);
  filter.restart();
  limiter.restart();
  bridge.forget_place();
  doubts.clear();
  gave_up = true;
}

StatusEntry Fusion::State::fused_status() const {
  StatusEntry entry;
  entry.stamp = now;
  entry.source = PoseSource::kFused;
  if (!filter.started()) {
    entry.state = Verdict::kLost;
    entry.score = 0.0;
    entry.reasons.emplace_back(gave_up ? "the halves say they are lost or somewhere else"
                                       : "no usable pose has come yet");
    return entry;
  }
  entry.score = 0.0;
  for (const auto& [source, monitor] : monitors) {
    if (monitor.heard()) entry.score = std::max(entry.score, monitor.status(now).score);
  }
  if (all_lost_for()) {
    entry.state = Verdict::kSuspect;
    entry.reasons.emplace_back("every half that speaks says it is lost");
  } else if (silent_until && now >= *silent_until &&
             common::to_seconds(now - *silent_until) < options.supervision.help_after) {
    entry.state = Verdict::kSuspect;
    entry.reasons.emplace_back("both halves were silent until a moment ago: the robot may have been carried");
  }
  for (const auto& [source, doubt] : doubts) {
    if (!monitors.at(source).speaks(now)) continue;
    if (doubt.elsewhere_since) {
      entry.state = Verdict::kLost;
      entry.score = 0.0;
      entry.reasons.push_back(
          fmt::format("the {} half was lost and has found itself somewhere else", common::to_string(source)));
    } else if (entry.state == Verdict::kTracking) {
      entry.state = Verdict::kSuspect;
      entry.reasons.push_back(
          fmt::format("the {} half does not track any more, and the other has not confirmed the pose since",
                      common::to_string(source)));
    }
  }
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
    const UncertainPose pose = target == PoseSource::kLaser ? filter.state() : *bridge.to_visual(filter.state());
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
  // Without odometry nothing tells the robot's own motion from a correction, and none may be held back.
  if (odometry.empty()) limiter.restart();
  const UncertainPose pose = limiter.follow(now, filter.state(), filter.T_odom_base());
  CorrectedPose corrected;
  corrected.estimate.stamp = now;
  corrected.estimate.source = PoseSource::kFused;
  corrected.estimate.map_epoch = epochs[*map_frame];
  corrected.estimate.pose = pose.pose;
  corrected.estimate.covariance = pose.covariance;
  corrected.estimate.state = verdict.state == Verdict::kSuspect ? TrackingState::kUncertain : TrackingState::kTracking;
  corrected.T_map_odom = pose.pose * filter.T_odom_base().inverse();
  output.pose = corrected;
  published.push_back({now, filter.T_odom_base()});
}

common::Result<std::unique_ptr<Fusion>> Fusion::create(const FusionOptions& options) {
  const double steps = 90.0 / options.alignment.seed004.angle_step;
  if (!(std::abs(steps - std::round(steps)) < 1e-9) || steps < 1.0) {
    return common::invalid_input(fmt::format("fusion.alignment.seed004.angle_step: {} does not divide 90 degrees",
                                             options.alignment.seed004.angle_step));
  }
  return std::unique_ptr<Fusion>(new Fusion(options));
}

Fusion::Fusion(const FusionOptions& options) : state_(std::make_unique<State>(options)) {}
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
  s.filter.move_to(odometry.pose, 0.0);
  s.now = odometry.stamp;
  s.use_waiting(output);
  s.give_up_if_carried();
  s.command_lost_halves(output);
  s.write_status(output);
  s.publish(output);
  return output;
}

FusionOutput Fusion::process(const PoseEstimate& estimate) {
  FusionOutput output;
  State& s = *state_;
  output.rejected = flaw_of(estimate);
  if (output.rejected) return output;
  if (!s.accept_epoch(estimate, output)) {
    output.rejected = fmt::format("the pose is of map epoch {}, which is over", estimate.map_epoch);
    return output;
  }
  if (s.odometry.empty() && !s.filter.started()) s.now = estimate.stamp;
  s.use_waiting(output);
  const bool late = estimate.stamp < s.now;
  s.take_doubt(estimate);
  s.hear(estimate.stamp);
  s.monitors.at(estimate.source).estimated(estimate);
  const auto place = std::find_if(s.published.rbegin(), s.published.rend(),
                                  [&](const PublishedPose& pose) { return pose.stamp < estimate.stamp; });
  const auto odometry = s.odometry_at(s.by_laser_clock(estimate).stamp);
  s.received.push_back({estimate.stamp, estimate.source, estimate.state,
                        odometry ? odometry->T_odom_base : s.filter.T_odom_base(),
                        late ? static_cast<std::size_t>(s.published.rend() - place) : s.published.size()});
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
  state_->bridge.use(state_->keeper.accepted());
}

FusionOutput Fusion::align_now() {
  FusionOutput output;
  state_->report(state_->keeper.align(), output);
  state_->bridge.use(state_->keeper.accepted());
  return output;
}

FusionResult Fusion::finish(const common::Trajectory2& laser_final, const common::Trajectory2& visual_final) {
  State& s = *state_;
  const auto laser = anchors_of(laser_final, PoseSource::kLaser, s.received);
  const auto visual = anchors_of(visual_final, PoseSource::kVisual, s.received);
  FusionResult result;
  result.alignment = align_trajectories(path_of(laser), path_of(visual), s.options.alignment);
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
  result.fused_final = smooth_path(s.published, anchors);
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
