// SPDX-License-Identifier: BSD-3-Clause
// How well the laser finds itself in a finished map: one run over all of a recording, and global starts at random times
// of it. Markdown on standard output.
//
//   benchmark_localization --map OUT/map --mapped RECORDING --recording RECORDING [options]
//   benchmark_localization --hold-out RECORDING [options]
//
// options: [--starts N] [--seed N] [--seconds S] [--set laser.localization.key=value]... [--verbose]
//
// --mapped is the recording the map was made from: its ground truth and the map's own path give the transform between
// the map's frame and the truth's. Both recordings' truth must be in one frame. --hold-out needs no truth: the map is
// made from every second scan, the others are localised in it and compared with the mapped path.

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
#include "laser_slam/random_stream.hpp"
#include "service/map_source.hpp"

namespace slamfuse {
namespace {

constexpr double kNear = 0.5;        // [m] of a right fix
constexpr double kNearAngle = 10.0;  // [deg]
constexpr double kAllowed = 10.0;    // [s] of driving to find the pose
constexpr common::Nanoseconds kTruthGap = common::kNanosecondsPerSecond / 10;
constexpr double kLongestStep = 1.5;   // [s] without a scan: carried
constexpr double kStandsStill = 0.02;  // [m/s] slower is not driving

struct Arguments {
  std::string map;
  std::string mapped;
  std::string recording;
  std::string hold_out;
  int starts = 200;
  std::uint64_t seed = 1;
  double seconds = 20.0;
  std::vector<std::string> settings;
  bool verbose = false;
};

struct Input {
  std::string laser;
  common::LaserCalibration calibration;
  std::vector<common::SensorMessage> messages;
  std::vector<std::optional<common::Pose2>> truth;  // at each message, in the map's frame
};

/// What came of one start.
struct Outcome {
  double started = 0.0;             // [s] into the recording
  std::optional<double> first_fix;  // [s] of driving until TRACKING was claimed rightly
  int claims = 0;                   // scans with TRACKING
  int false_claims = 0;             // of those, wrong
  bool ever_false = false;          // false at the first claim
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

/// Brings the recording's truth into the map's frame.
common::Result<void> add_truth(const Arguments& arguments, Input& input) {
  const auto map_path = common::read_trajectory(std::filesystem::path(arguments.map) / "laser.tum");
  if (!map_path) return tl::unexpected(map_path.error());
  const auto map_truth = common::read_ground_truth(arguments.mapped);
  if (!map_truth) return tl::unexpected(map_truth.error());
  const auto fit = common::evaluate_trajectory(common::to_planar(*map_path), *map_truth, {});
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
                                                     std::uint64_t seed) {
  auto slam = laser_slam::LaserSlam::create(options, input.laser, input.calibration, seed, 2);
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

/// A global start at message `first`, followed until the first right fix and a while longer. Ends at a carry.
common::Result<Outcome> start_at(const Input& input, const laser_slam::LaserSlamOptions& options,
                                 const laser_slam::LocalizationMap& map, std::size_t first, std::uint64_t seed,
                                 double seconds, std::vector<double>& update_ms) {
  auto module = laser_slam::LaserLocalization::create(options, input.laser, input.calibration, map, seed);
  if (!module) return tl::unexpected(module.error());
  Outcome outcome;
  const common::Nanoseconds begin = common::stamp_of(input.messages[first]);
  outcome.started = common::to_seconds(begin - common::stamp_of(input.messages.front()));
  std::optional<common::StampedPose2> last;
  double driving = 0.0;
  for (std::size_t i = first; i < input.messages.size(); ++i) {
    const common::Nanoseconds stamp = common::stamp_of(input.messages[i]);
    if (common::to_seconds(stamp - begin) > seconds) break;
    const double before = cpu_seconds();
    const common::ProcessResult result = (*module)->process(input.messages[i]);
    if (!result.estimate) continue;
    update_ms.push_back(1e3 * (cpu_seconds() - before));
    const std::optional<common::Pose2>& truth = input.truth[i];
    if (!truth) continue;
    if (last) {
      const double step = common::to_seconds(stamp - last->stamp);
      const double moved = std::hypot(truth->x - last->pose.x, truth->y - last->pose.y) +
                           std::abs(common::angle_difference(truth->theta, last->pose.theta));
      if (step > kLongestStep) break;  // carried
      if (moved > kStandsStill * step) driving += step;
    }
    last = {stamp, *truth};
    if (result.estimate->state != common::TrackingState::kTracking) continue;
    const bool right = is_right(result.estimate->pose, *truth);
    if (outcome.claims == 0 && !right) outcome.ever_false = true;
    ++outcome.claims;
    if (!right) ++outcome.false_claims;
    if (right && !outcome.first_fix) outcome.first_fix = driving;
  }
  return outcome;
}

/// The scans that leave time to drive before the end or the next carry.
std::vector<std::size_t> possible_starts(const Input& input) {
  std::vector<std::size_t> scans;
  for (std::size_t i = 0; i < input.messages.size(); ++i) {
    if (std::holds_alternative<common::LaserScan>(input.messages[i]) && input.truth[i]) scans.push_back(i);
  }
  const auto stamp = [&](std::size_t i) { return common::stamp_of(input.messages[scans[i]]); };
  std::vector<std::size_t> possible;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    std::size_t end = i;
    while (end + 1 < scans.size() && common::to_seconds(stamp(end + 1) - stamp(end)) <= kLongestStep &&
           common::to_seconds(stamp(end) - stamp(i)) < kAllowed + 2.0) {
      ++end;
    }
    if (common::to_seconds(stamp(end) - stamp(i)) >= kAllowed + 2.0) possible.push_back(scans[i]);
  }
  return possible;
}

common::Result<void> global_starts(const Input& input, const laser_slam::LaserSlamOptions& options,
                                   const laser_slam::LocalizationMap& map, const Arguments& arguments) {
  const std::vector<std::size_t> possible = possible_starts(input);
  if (possible.empty()) return common::invalid_input("no start leaves enough time with truth");
  laser_slam::RandomStream random(arguments.seed, 7);
  std::vector<double> fixes, update_ms;
  int successes = 0, false_first = 0, starts_with_false = 0;
  long claims = 0, false_claims = 0;
  for (int i = 0; i < arguments.starts; ++i) {
    const auto pick = static_cast<std::size_t>(random.uniform() * static_cast<double>(possible.size()));
    const auto outcome = start_at(input, options, map, possible[pick], arguments.seed + static_cast<std::uint64_t>(i),
                                  arguments.seconds, update_ms);
    if (!outcome) return tl::unexpected(outcome.error());
    if (outcome->first_fix) fixes.push_back(*outcome->first_fix);
    const bool success = outcome->first_fix && *outcome->first_fix <= kAllowed && !outcome->ever_false;
    successes += success ? 1 : 0;
    false_first += outcome->ever_false ? 1 : 0;
    starts_with_false += outcome->false_claims > 0 ? 1 : 0;
    claims += outcome->claims;
    false_claims += outcome->false_claims;
    if (arguments.verbose && (!success || outcome->false_claims > 0)) {
      fmt::print(stderr, "start at {:.1f} s: fix after {:.1f} s, {} of {} claims false\n", outcome->started,
                 outcome->first_fix.value_or(-1.0), outcome->false_claims, outcome->claims);
    }
  }
  const double n = arguments.starts;
  fmt::print(
      "| starts | success | fix p50 | fix p95 | false first fix | starts with a false claim | false claims | update "
      "median | p99 |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|\n");
  fmt::print(
      "| {} | {:.1f} % | {:.1f} s | {:.1f} s | {:.1f} % | {:.1f} % | {:.2f} % of scans | {:.1f} ms | {:.1f} ms |\n\n",
      arguments.starts, 100.0 * successes / n, quantile(fixes, 0.5), quantile(fixes, 0.95), 100.0 * false_first / n,
      100.0 * starts_with_false / n,
      100.0 * static_cast<double>(false_claims) / std::max<double>(1.0, static_cast<double>(claims)),
      quantile(update_ms, 0.5), quantile(update_ms, 0.99));
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
  const auto map = arguments.hold_out.empty() ? service::read_localization_map(arguments.map)
                                              : hold_out(*input, options, arguments.seed);
  if (!map) return tl::unexpected(map.error());
  if (arguments.hold_out.empty()) {
    if (auto done = add_truth(arguments, *input); !done) return done;
  }
  fmt::print("map of {} x {} cells\n", map->grid.width, map->grid.height);
  if (auto done = whole_run(*input, options, *map, arguments); !done) return done;
  return arguments.starts > 0 ? global_starts(*input, options, *map, arguments) : common::Result<void>{};
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) {
  slamfuse::Arguments arguments;
  CLI::App app("Measures localisation in a finished map.");
  auto* map = app.add_option("--map", arguments.map);
  auto* mapped = app.add_option("--mapped", arguments.mapped)->needs(map);
  auto* recording = app.add_option("--recording", arguments.recording)->needs(mapped);
  app.add_option("--hold-out", arguments.hold_out)->excludes(recording);
  app.add_option("--starts", arguments.starts);
  app.add_option("--seed", arguments.seed);
  app.add_option("--seconds", arguments.seconds);
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
