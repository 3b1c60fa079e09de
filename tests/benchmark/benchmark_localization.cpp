// SPDX-License-Identifier: BSD-3-Clause
// How well the laser finds itself in a finished map: one run over all of a recording, and global starts at random times
// of it. Markdown on standard output.
//
//   benchmark_localization --mapped RECORDING [--mapped-to S | --map OUT/map] --recording RECORDING [options]
//   benchmark_localization --hold-out RECORDING [options]
//
// options: [--starts N] [--seed N] [--seconds S] [--threads N] [--set laser.localization.key=value]... [--verbose]
//
// The map is made from --mapped (its first S seconds), or is read from --map if that was made from it before: the
// ground truth of --mapped and the map's own path give the transform between the map's frame and the truth's. Both
// recordings' truth must be in one frame. --hold-out needs no truth: the map is made from every second scan, the others
// are localised in it and compared with the mapped path.
//
// Times are seconds of driving: time in which the true pose moves. A start is given --seconds of it, and is followed
// for a while after its first fix, so that a fix that turns out false is seen.

#include <ctime>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/angle.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "common/tum.hpp"
#include "laser_slam/laser_localization.hpp"
#include "laser_slam/laser_slam.hpp"
#include "laser_slam/parallel_for.hpp"
#include "laser_slam/random_stream.hpp"
#include "laser_slam/scan_beams.hpp"
#include "laser_slam/scan_explanation.hpp"
#include "service/map_source.hpp"

namespace slamfuse {
namespace {

constexpr double kNear = 0.5;        // [m] of a right fix
constexpr double kNearAngle = 10.0;  // [deg]
constexpr double kAllowed = 10.0;    // [s] of driving to find the pose
constexpr common::Nanoseconds kTruthGap = common::kNanosecondsPerSecond / 10;
constexpr double kLongestStep = 1.5;   // [s] without a scan: carried
constexpr double kStandsStill = 0.02;  // [m/s, rad/s] slower is not driving ...
constexpr double kHalfWindow = 0.5;    // [s] ... over this long before and after: noise of the truth is no motion
constexpr double kBetter = 0.1;        // share of the beams more that the map explains at one of two poses
constexpr double kWatched = 10.0;      // [s] of driving for which a fix is watched

struct Arguments {
  std::string map;
  std::string mapped;
  double mapped_to = HUGE_VAL;
  std::string recording;
  std::string hold_out;
  int starts = 200;
  int threads = 1;
  std::uint64_t seed = 1;
  double seconds = 30.0;
  std::vector<std::string> settings;
  bool verbose = false;
};

struct Input {
  std::string laser;
  common::LaserCalibration calibration;
  std::vector<common::SensorMessage> messages;
  std::vector<std::optional<common::Pose2>> truth;  // at each message, in the map's frame
  std::vector<std::size_t> scans;                   // the messages that are scans with truth
  std::vector<double> driving;                      // [s] until each of these scans, in all
  std::vector<bool> carried;                        // whether the robot was carried before it
};

/// What came of one start. Times in seconds of driving.
struct Outcome {
  double started = 0.0;              // [s] into the recording
  double waited = 0.0;               // [s] on the clock until the first fix
  std::optional<double> thought_of;  // the true place was among the hypotheses
  std::optional<double> best;        // it was the most probable one, for good
  std::optional<double> sure;        // it had the probability that TRACKING asks for
  std::optional<double> first_fix;   // TRACKING was claimed rightly
  int claims = 0;                    // scans with TRACKING
  int false_claims = 0;              // of those, wrong
  int doubtful_truth = 0;            // of the false ones, those where the map speaks against the truth, not the claim
  bool ever_false = false;           // false at the first claim
  std::size_t most_hypotheses = 0;
  std::vector<double> update_ms;
};

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size() - 1)))];
}

common::Result<Input> load_messages(const std::string& path) {
  auto recording = common::open_recording(path);
  if (!recording) return tl::unexpected(recording.error());
  const common::RecordingInfo& info = (*recording)->info();
  if (info.calibration.lasers.empty()) return common::invalid_input(path + ": no laser");
  Input input;
  input.laser = info.calibration.lasers.begin()->first;
  input.calibration = info.calibration.lasers.begin()->second;
  while (true) {
    auto item = (*recording)->next();
    if (!item) return tl::unexpected(item.error());
    if (!*item) break;
    auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message && !std::holds_alternative<common::Image>(*message)) input.messages.push_back(std::move(*message));
  }
  return input;
}

/// A map and its path.
struct Mapped {
  laser_slam::LocalizationMap map;
  common::Trajectory2 path;
};

/// Reads the map that was made from a recording, or makes it.
common::Result<Mapped> map_of(const Arguments& arguments, const laser_slam::LaserSlamOptions& options) {
  if (!arguments.map.empty()) {
    auto map = service::read_localization_map(arguments.map);
    if (!map) return tl::unexpected(map.error());
    const auto path = common::read_trajectory(std::filesystem::path(arguments.map) / "laser.tum");
    if (!path) return tl::unexpected(path.error());
    return Mapped{std::move(*map), common::to_planar(*path)};
  }
  const auto input = load_messages(arguments.mapped);
  if (!input) return tl::unexpected(input.error());
  auto slam =
      laser_slam::LaserSlam::create(options, input->laser, input->calibration, arguments.seed, arguments.threads);
  if (!slam) return tl::unexpected(slam.error());
  const common::Nanoseconds begin = common::stamp_of(input->messages.front());
  for (const common::SensorMessage& message : input->messages) {
    if (common::to_seconds(common::stamp_of(message) - begin) <= arguments.mapped_to) (*slam)->process(message);
  }
  (*slam)->refine();
  auto state = (*slam)->serialize();
  if (!state) return tl::unexpected(state.error());
  return Mapped{{arguments.mapped, (*slam)->grid(), std::move(*state)}, (*slam)->final_trajectory()};
}

/// Brings the recording's truth into the map's frame.
common::Result<void> add_truth(const Arguments& arguments, const common::Trajectory2& map_path, Input& input) {
  const auto map_truth = common::read_ground_truth(arguments.mapped);
  if (!map_truth) return tl::unexpected(map_truth.error());
  const auto fit = common::evaluate_trajectory(map_path, *map_truth, {});
  if (!fit) return tl::unexpected(fit.error());
  auto truth = common::read_ground_truth(arguments.recording);
  if (!truth) return tl::unexpected(truth.error());
  const common::Similarity2 T_map_world = fit->T_reference_estimate.inverse();
  for (common::StampedPose2& pose : *truth) pose.pose = T_map_world * pose.pose;
  for (const common::SensorMessage& message : input.messages) {
    input.truth.push_back(common::pose_at(*truth, common::stamp_of(message), kTruthGap));
  }
  return {};
}

/// Makes the map from every second scan, which are taken out of the input; the mapped path becomes the truth.
common::Result<laser_slam::LocalizationMap> hold_out(Input& input, const laser_slam::LaserSlamOptions& options,
                                                     std::uint64_t seed, int threads) {
  auto slam = laser_slam::LaserSlam::create(options, input.laser, input.calibration, seed, threads);
  if (!slam) return tl::unexpected(slam.error());
  std::vector<common::SensorMessage> held;
  std::vector<std::optional<std::size_t>> poses_before;  // of each held scan: poses of the map's path so far
  std::size_t poses = 0;
  bool map_it = true;
  for (common::SensorMessage& message : input.messages) {
    const bool scan = std::holds_alternative<common::LaserScan>(message);
    if (!scan || map_it) poses += (*slam)->process(message).estimate ? 1 : 0;
    if (!scan || !map_it) {
      held.push_back(std::move(message));
      poses_before.push_back(scan ? std::optional(poses) : std::nullopt);
    }
    if (scan) map_it = !map_it;
  }
  (*slam)->refine();
  const common::Trajectory2 path = (*slam)->final_trajectory();
  for (const std::optional<std::size_t>& before : poses_before) {
    const bool between = before && *before > 0 && *before < path.size();
    input.truth.push_back(between ? std::optional(common::interpolate(path[*before - 1].pose, path[*before].pose, 0.5))
                                  : std::nullopt);
  }
  input.messages = std::move(held);
  auto state = (*slam)->serialize();
  if (!state) return tl::unexpected(state.error());
  return laser_slam::LocalizationMap{"every second scan", (*slam)->grid(), std::move(*state)};
}

bool is_right(const common::Pose2& estimate, const common::Pose2& truth) {
  return std::hypot(estimate.x - truth.x, estimate.y - truth.y) < kNear &&
         std::abs(common::to_degrees(common::angle_difference(estimate.theta, truth.theta))) < kNearAngle;
}

/// Marks the time the robot drove, and where it was carried.
void add_driving(Input& input) {
  for (std::size_t i = 0; i < input.messages.size(); ++i) {
    if (std::holds_alternative<common::LaserScan>(input.messages[i]) && input.truth[i]) input.scans.push_back(i);
  }
  const std::size_t count = input.scans.size();
  const auto seconds_between = [&](std::size_t a, std::size_t b) {
    return common::to_seconds(common::stamp_of(input.messages[input.scans[b]]) -
                              common::stamp_of(input.messages[input.scans[a]]));
  };
  input.driving.assign(count, 0.0);
  input.carried.assign(count, false);
  for (std::size_t i = 1; i < count; ++i) input.carried[i] = seconds_between(i - 1, i) > kLongestStep;
  for (std::size_t i = 1; i < count; ++i) {
    input.driving[i] = input.driving[i - 1];
    if (input.carried[i]) continue;
    std::size_t first = i - 1;
    while (first > 0 && !input.carried[first] && seconds_between(first, i - 1) < kHalfWindow) --first;
    std::size_t last = i;
    while (last + 1 < count && !input.carried[last + 1] && seconds_between(i, last) < kHalfWindow) ++last;
    const common::Pose2& from = *input.truth[input.scans[first]];
    const common::Pose2& to = *input.truth[input.scans[last]];
    const double moved =
        std::hypot(to.x - from.x, to.y - from.y) + std::abs(common::angle_difference(to.theta, from.theta));
    if (moved > kStandsStill * seconds_between(first, last)) input.driving[i] += seconds_between(i - 1, i);
  }
}

/// Whether the map explains a scan clearly better at `claim` than at `truth`: where a path and the map drawn along it
/// disagree (a loop was closed since) the path is no truth for who localises in the map.
bool speaks_against_truth(const laser_slam::LikelihoodField& field, const Input& input, const common::LaserScan& scan,
                          const laser_slam::LaserSlamOptions& options, const common::Pose2& claim,
                          const common::Pose2& truth) {
  const auto beams = laser_slam::project_scan(
      scan, input.calibration, {options.max_range, options.map.free_beyond_range, options.localization.beams},
      Eigen::Vector3d::Zero());
  if (!beams) return false;
  const auto agreement = [&](const common::Pose2& pose) {
    return laser_slam::explain_scan(field, common::to_pose2(input.calibration.T_base_laser).translation(),
                                    beams->match_points, pose, options.localization.explained_distance)
        .agreement(options.localization.short_weight);
  };
  return agreement(claim) >= agreement(truth) + kBetter;
}

/// A global start at scan `first`, followed until a while after the first right fix. Ends at a carry.
common::Result<Outcome> start_at(const Input& input, const laser_slam::LaserSlamOptions& options,
                                 const laser_slam::LocalizationMap& map, const laser_slam::LikelihoodField& field,
                                 std::size_t first, std::uint64_t seed, double seconds) {
  auto module = laser_slam::LaserLocalization::create(options, input.laser, input.calibration, map, seed);
  if (!module) return tl::unexpected(module.error());
  Outcome outcome;
  const common::Nanoseconds begin = common::stamp_of(input.messages[input.scans[first]]);
  outcome.started = common::to_seconds(begin - common::stamp_of(input.messages.front()));
  // The wheels tell where they are before the scan does: its own odometry is known when the program starts with it.
  std::size_t begin_with = input.scans[first];
  while (begin_with > 0 && !std::holds_alternative<common::WheelOdometry>(input.messages[begin_with])) --begin_with;
  std::size_t scan = first;  // that comes next
  for (std::size_t i = begin_with; i < input.messages.size() && scan < input.scans.size(); ++i) {
    const double before = cpu_seconds();
    const common::ProcessResult result = (*module)->process(input.messages[i]);
    if (i < input.scans[first]) continue;
    if (result.estimate) outcome.update_ms.push_back(1e3 * (cpu_seconds() - before));
    if (i != input.scans[scan]) continue;
    if (scan != first && input.carried[scan]) break;
    const double driving = input.driving[scan] - input.driving[first];
    ++scan;
    if (driving > (outcome.first_fix ? *outcome.first_fix + kWatched : seconds)) break;
    if (!result.estimate) continue;
    const common::Pose2& truth = *input.truth[i];
    const auto hypotheses = (*module)->hypotheses();
    outcome.most_hypotheses = std::max(outcome.most_hypotheses, hypotheses.size());
    if (!hypotheses.empty()) {
      const bool held = std::any_of(hypotheses.begin(), hypotheses.end(),
                                    [&](const laser_slam::Hypothesis& h) { return is_right(h.mean, truth); });
      if (held && !outcome.thought_of) outcome.thought_of = driving;
      const bool best = is_right(hypotheses.front().mean, truth);
      if (!best) outcome.best.reset();
      if (best && !outcome.best) outcome.best = driving;
      if (best && hypotheses.front().mass >= options.localization.monitor.sure_mass && !outcome.sure) {
        outcome.sure = driving;
      }
    }
    if (result.estimate->state != common::TrackingState::kTracking) continue;
    const bool right = is_right(result.estimate->pose, truth);
    if (outcome.claims == 0 && !right) outcome.ever_false = true;
    ++outcome.claims;
    if (!right) {
      ++outcome.false_claims;
      const auto& laser_scan = std::get<common::LaserScan>(input.messages[i]);
      if (speaks_against_truth(field, input, laser_scan, options, result.estimate->pose, truth)) {
        ++outcome.doubtful_truth;
      }
    }
    if (!right || outcome.first_fix) continue;
    outcome.first_fix = driving;
    outcome.waited = common::to_seconds(result.estimate->stamp - begin);
  }
  return outcome;
}

/// The scans after which the robot drives long enough before the end or the next carry.
std::vector<std::size_t> possible_starts(const Input& input) {
  std::vector<std::size_t> possible;
  std::size_t end = input.scans.size();
  for (std::size_t i = input.scans.size(); i-- > 0;) {
    if (input.driving[end - 1] - input.driving[i] >= kAllowed + 2.0) possible.push_back(i);
    if (input.carried[i]) end = i;
  }
  std::reverse(possible.begin(), possible.end());
  return possible;
}

common::Result<void> global_starts(const Input& input, const laser_slam::LaserSlamOptions& options,
                                   const laser_slam::LocalizationMap& map, const Arguments& arguments) {
  const std::vector<std::size_t> possible = possible_starts(input);
  if (possible.empty()) return common::invalid_input("no start leaves enough time with truth");
  laser_slam::RandomStream random(arguments.seed, 7);
  std::vector<std::size_t> picked;
  for (int i = 0; i < arguments.starts; ++i) {
    picked.push_back(possible[static_cast<std::size_t>(random.uniform() * static_cast<double>(possible.size()))]);
  }
  const laser_slam::LikelihoodField field(map.grid, options.localization.beam_model.farthest);
  std::vector<common::Result<Outcome>> outcomes(picked.size(), Outcome{});
  laser_slam::parallel_for(arguments.starts, arguments.threads, [&](int i, int) {
    const auto start = static_cast<std::size_t>(i);
    outcomes[start] = start_at(input, options, map, field, picked[start], arguments.seed + start, arguments.seconds);
  });
  std::vector<double> thought_of, best, sure, fixes, waited, update_ms, hypotheses;
  int successes = 0, false_first = 0, starts_with_false = 0, doubtful_truth = 0;
  long claims = 0, false_claims = 0;
  const auto add = [](std::vector<double>& to, const std::optional<double>& time) {
    to.push_back(time.value_or(HUGE_VAL));
  };
  for (const auto& outcome : outcomes) {
    if (!outcome) return tl::unexpected(outcome.error());
    add(thought_of, outcome->thought_of);
    add(best, outcome->best);
    add(sure, outcome->sure);
    add(fixes, outcome->first_fix);
    if (outcome->first_fix) waited.push_back(outcome->waited);
    hypotheses.push_back(static_cast<double>(outcome->most_hypotheses));
    update_ms.insert(update_ms.end(), outcome->update_ms.begin(), outcome->update_ms.end());
    const bool success = outcome->first_fix && *outcome->first_fix <= kAllowed && !outcome->ever_false;
    successes += success ? 1 : 0;
    false_first += outcome->ever_false ? 1 : 0;
    starts_with_false += outcome->false_claims > 0 ? 1 : 0;
    doubtful_truth += outcome->false_claims > 0 && 2 * outcome->doubtful_truth > outcome->false_claims ? 1 : 0;
    claims += outcome->claims;
    false_claims += outcome->false_claims;
    if (arguments.verbose && (!success || outcome->false_claims > 0)) {
      fmt::print(stderr,
                 "start at {:.1f} s: thought of after {:.1f} s, best {:.1f} s, sure {:.1f} s, fix {:.1f} s; {} of {} "
                 "claims false, in {} the map speaks for them\n",
                 outcome->started, outcome->thought_of.value_or(HUGE_VAL), outcome->best.value_or(HUGE_VAL),
                 outcome->sure.value_or(HUGE_VAL), outcome->first_fix.value_or(HUGE_VAL), outcome->false_claims,
                 outcome->claims, outcome->doubtful_truth);
    }
  }
  const double n = arguments.starts;
  fmt::print(
      "| starts | success | fix p50 | fix p95 | false first fix | starts with a false claim | false claims | update "
      "median | p99 | max |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  fmt::print(
      "| {} | {:.1f} % | {:.1f} s | {:.1f} s | {:.1f} % | {:.1f} % | {:.2f} % of scans | {:.1f} ms | {:.1f} ms | "
      "{:.1f} ms |\n\n",
      arguments.starts, 100.0 * successes / n, quantile(fixes, 0.5), quantile(fixes, 0.95), 100.0 * false_first / n,
      100.0 * starts_with_false / n,
      100.0 * static_cast<double>(false_claims) / std::max<double>(1.0, static_cast<double>(claims)),
      quantile(update_ms, 0.5), quantile(update_ms, 0.99), quantile(update_ms, 1.0));
  fmt::print(
      "in {} of the {} starts with a false claim the map explains most of these scans better at the claimed pose\n",
      doubtful_truth, starts_with_false);
  const auto line = [](const char* what, const std::vector<double>& times) {
    fmt::print("{}: p50 {:.1f} s, p90 {:.1f} s, p95 {:.1f} s, p99 {:.1f} s\n", what, quantile(times, 0.5),
               quantile(times, 0.9), quantile(times, 0.95), quantile(times, 0.99));
  };
  line("the true place is among the hypotheses after", thought_of);
  line("it is the most probable one for good after", best);
  line("it is sure after", sure);
  line("it is claimed after", fixes);
  line("the same on the clock, standing included,", waited);
  fmt::print("hypotheses at most: p50 {:.0f}, p95 {:.0f}\n", quantile(hypotheses, 0.5), quantile(hypotheses, 0.95));
  return {};
}

/// The whole recording in one go: error while TRACKING, and how each carry was noticed and cured.
common::Result<void> whole_run(const Input& input, const laser_slam::LaserSlamOptions& options,
                               const laser_slam::LocalizationMap& map, const Arguments& arguments) {
  auto module = laser_slam::LaserLocalization::create(options, input.laser, input.calibration, map, arguments.seed);
  if (!module) return tl::unexpected(module.error());
  double squares = 0.0, worst = 0.0;
  int tracking = 0, wrong = 0, scans = 0;
  common::Nanoseconds last = 0;
  std::string carries;
  bool carried = false, noticed = false;
  common::Nanoseconds carried_at = 0, noticed_at = 0;
  std::vector<double> update_ms;
  for (std::size_t i = 0; i < input.messages.size(); ++i) {
    const double before = cpu_seconds();
    const common::ProcessResult result = (*module)->process(input.messages[i]);
    const double took = cpu_seconds() - before;
    if (!result.estimate) continue;
    const common::PoseEstimate& estimate = *result.estimate;
    if (scans > 0 && common::to_seconds(estimate.stamp - last) > kLongestStep) {
      carried = true;
      noticed = false;
      carried_at = estimate.stamp;
    }
    last = estimate.stamp;
    ++scans;
    const std::optional<common::Pose2>& truth = input.truth[i];
    if (arguments.verbose && truth) {
      fmt::print(stderr, "{:.2f} {} error {:.2f} m agreement {:.2f}\n",
                 common::to_seconds(estimate.stamp - common::stamp_of(input.messages.front())),
                 common::to_string(estimate.state), std::hypot(estimate.pose.x - truth->x, estimate.pose.y - truth->y),
                 estimate.health.scan_likelihood.value_or(-1.0));
      for (const common::Event& event : estimate.events) fmt::print(stderr, "  {}: {}\n", event.kind, event.detail);
    }
    if (carried && !noticed && estimate.state == common::TrackingState::kLost) {
      noticed = true;
      noticed_at = estimate.stamp;
    }
    if (estimate.state != common::TrackingState::kTracking) continue;
    if (carried && noticed) {
      carries +=
          fmt::format("carried: LOST after {:.1f} s, found again after {:.1f} s\n",
                      common::to_seconds(noticed_at - carried_at), common::to_seconds(estimate.stamp - carried_at));
      carried = false;
    }
    update_ms.push_back(1e3 * took);
    if (!truth) continue;
    ++tracking;
    const double error = std::hypot(estimate.pose.x - truth->x, estimate.pose.y - truth->y);
    if (!is_right(estimate.pose, *truth)) ++wrong;
    squares += error * error;
    worst = std::max(worst, error);
  }
  fmt::print(
      "whole run: TRACKING in {} of {} scans, {} of them wrong, error {:.3f} m rms, {:.3f} m at most; an update while "
      "TRACKING takes {:.1f} ms (median), {:.1f} ms (p99)\n{}",
      tracking, scans, wrong, std::sqrt(squares / std::max(1, tracking)), worst, quantile(update_ms, 0.5),
      quantile(update_ms, 0.99), carries);
  if (carried) fmt::print("the last carry was {}\n", noticed ? "noticed and not cured" : "not noticed");
  return {};
}

common::Result<void> run(const Arguments& arguments) {
  laser_slam::LaserSlamOptions options;
  const auto describe = [&options](common::OptionVisitor& visit) { visit.nested("laser", options, "Laser SLAM."); };
  for (const std::string& setting : arguments.settings) {
    if (auto done = common::set_option(setting, describe); !done) return done;
  }
  auto input = load_messages(arguments.hold_out.empty() ? arguments.recording : arguments.hold_out);
  if (!input) return tl::unexpected(input.error());
  common::Result<laser_slam::LocalizationMap> map;
  if (arguments.hold_out.empty()) {
    auto mapped = map_of(arguments, options);
    if (!mapped) return tl::unexpected(mapped.error());
    if (auto done = add_truth(arguments, mapped->path, *input); !done) return done;
    map = std::move(mapped->map);
  } else {
    map = hold_out(*input, options, arguments.seed, arguments.threads);
  }
  if (!map) return tl::unexpected(map.error());
  add_driving(*input);
  fmt::print("map of {} x {} cells; {:.0f} s of driving\n", map->grid.width, map->grid.height, input->driving.back());
  if (auto done = whole_run(*input, options, *map, arguments); !done) return done;
  return arguments.starts > 0 ? global_starts(*input, options, *map, arguments) : common::Result<void>{};
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) {
  slamfuse::Arguments arguments;
  CLI::App app("Measures localisation in a finished map.");
  auto* mapped = app.add_option("--mapped", arguments.mapped);
  app.add_option("--mapped-to", arguments.mapped_to)->needs(mapped);
  app.add_option("--map", arguments.map)->needs(mapped);
  auto* recording = app.add_option("--recording", arguments.recording)->needs(mapped);
  app.add_option("--hold-out", arguments.hold_out)->excludes(recording);
  app.add_option("--starts", arguments.starts);
  app.add_option("--seed", arguments.seed);
  app.add_option("--seconds", arguments.seconds);
  app.add_option("--threads", arguments.threads)->check(CLI::Range(1, 64));
  app.add_option("--set", arguments.settings);
  app.add_flag("--verbose", arguments.verbose);
  CLI11_PARSE(app, argc, argv);
  if (arguments.recording.empty() == arguments.hold_out.empty()) {
    fmt::print(stderr, "give --map, --mapped and --recording, or --hold-out\n");
    return 2;
  }
  if (const auto done = slamfuse::run(arguments); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
  return 0;
}
