// SPDX-License-Identifier: BSD-3-Clause
// What the fusion promises when the robot is carried and when a sensor breaks, measured with the pipeline of
// `slamfuse run`. SLAMFUSE_RECORDINGS names the folder with sim/.
//
//     benchmark_recovery [GROUP [SEED [PART]]]     only the groups whose name contains GROUP: carries, faults; of the
//                                                  faults only those whose name contains PART
//
// Carries: localisation in the map of a mapping run, whose path also gives the transform from the map's frame to the
// truth's; three arms. Faults: one half silenced, frozen or fed another recording for ten seconds.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "benchmark/bar_table.hpp"
#include "benchmark/fusion_run.hpp"
#include "common/angle.hpp"
#include "service/output_folder.hpp"
#include "service/run_files.hpp"

namespace slamfuse {
namespace {

namespace fs = std::filesystem;
using common::Nanoseconds;
using common::PoseSource;
using common::TrackingState;
using service::RunSummary;

/// A time in which the robot was carried.
struct Carry {
  Nanoseconds from = 0;
  Nanoseconds to = 0;
};

/// events.csv of a simulated recording.
std::vector<Carry> carries_of(const fs::path& recording) {
  std::vector<Carry> carries;
  std::ifstream file(recording / "events.csv");
  std::string line;
  while (std::getline(file, line)) {
    Carry carry;
    char comma = 0;
    std::istringstream row(line);
    if (row >> carry.from >> comma >> carry.to) carries.push_back(carry);
  }
  return carries;
}

/// A finished map, and where it lies in the frame of the truth.
struct FinishedMap {
  fs::path folder;
  common::Similarity2 T_truth_map;     ///< of the laser's map
  common::Similarity2 T_truth_visual;  ///< of the visual map
};

common::Result<FinishedMap> make_map(const fs::path& recording, double to, std::uint64_t seed, const fs::path& out) {
  FusionRun mapping;
  mapping.request.recording = recording;
  mapping.request.to = to;
  mapping.request.threads = 2;
  mapping.request.seed = seed;
  const auto summary = run(mapping);
  if (!summary) return tl::unexpected(summary.error());
  const auto fit = fit_to_truth(trajectory_of(*summary, "fused_final"), summary->truth);
  if (!fit) return tl::unexpected(fit.error());
  const auto visual = fit_to_truth(trajectory_of(*summary, "visual_final"), summary->truth);
  if (!visual) return tl::unexpected(visual.error());
  const auto folder = service::OutputFolder::create(out, service::ResultKind::kRun);
  if (!folder) return tl::unexpected(folder.error());
  if (auto written = write_run_files(*summary, **folder); !written) return tl::unexpected(written.error());
  if (auto published = (*folder)->publish(); !published) return tl::unexpected(published.error());
  return FinishedMap{out / "map", *fit, *visual};
}

/// What a run tells of itself, against the truth.
class Judge {
 public:
  Judge(const RunSummary& summary, const common::Similarity2& T_truth_map, common::Trajectory2 truth)
      : summary_(summary), truth_(std::move(truth)) {
    common::Trajectory2 tracking;
    const auto estimates = summary.log.estimates.find(PoseSource::kFused);
    if (estimates != summary.log.estimates.end()) {
      for (const auto& estimate : estimates->second) {
        if (estimate.state == TrackingState::kTracking) tracking.push_back({estimate.stamp, estimate.pose});
      }
    }
    errors_ = errors_under(T_truth_map, tracking, truth_);
  }

  /// The first verdict of this kind on a source from `from` on, before `until`; that which holds at `from` counts.
  std::optional<Nanoseconds> first_verdict(PoseSource source, const std::vector<fusion::Verdict>& kinds,
                                           Nanoseconds from, Nanoseconds until) const {
    std::optional<Nanoseconds> before;
    for (const auto& entry : summary_.log.status) {
      if (entry.source != source || entry.stamp >= until) continue;
      const bool is_it = std::find(kinds.begin(), kinds.end(), entry.state) != kinds.end();
      if (entry.stamp <= from) {
        before = is_it ? std::optional(from) : std::nullopt;
      } else if (before || is_it) {
        return before.value_or(entry.stamp);
      }
    }
    return before;
  }
  /// The first TRACKING pose that is right from `from` on.
  std::optional<Nanoseconds> first_right(Nanoseconds from) const {
    for (const auto& error : errors_) {
      if (error.stamp >= from && is_right(error)) return error.stamp;
    }
    return std::nullopt;
  }
  /// How many TRACKING poses between are wrong.
  long wrong(Nanoseconds from, Nanoseconds until) const {
    return std::count_if(errors_.begin(), errors_.end(), [&](const auto& error) {
      return error.stamp >= from && error.stamp < until && !is_right(error);
    });
  }
  double worst(Nanoseconds from, Nanoseconds until) const {
    double worst = 0.0;
    for (const auto& error : errors_) {
      if (error.stamp >= from && error.stamp < until) worst = std::max(worst, error.position);
    }
    return worst;
  }
  double rms(Nanoseconds from, Nanoseconds until) const {
    double sum = 0.0;
    double count = 0.0;
    for (const auto& error : errors_) {
      if (error.stamp < from || error.stamp >= until) continue;
      sum += error.position * error.position;
      count += 1.0;
    }
    return std::sqrt(sum / count);
  }
  double driven(Nanoseconds from, Nanoseconds until) const { return common::path_length(between(truth_, from, until)); }
  bool has_poses() const { return !errors_.empty(); }

 private:
  const RunSummary& summary_;
  common::Trajectory2 truth_;
  std::vector<common::PoseError> errors_;
};

/// The first scan or image of a run from a time on.
Nanoseconds first_estimate(const RunSummary& summary, Nanoseconds from) {
  Nanoseconds first = summary.last_stamp;
  for (const auto source : {PoseSource::kLaser, PoseSource::kVisual}) {
    const auto found = summary.log.estimates.find(source);
    if (found == summary.log.estimates.end()) continue;
    for (const auto& estimate : found->second) {
      if (estimate.stamp >= from) first = std::min(first, estimate.stamp);
    }
  }
  return first;
}

common::Trajectory2 without(const common::Trajectory2& trajectory, const Carry& cut) {
  common::Trajectory2 rest;
  for (auto pose : trajectory) {
    if (pose.stamp >= cut.from && pose.stamp < cut.to) continue;
    if (pose.stamp >= cut.to) pose.stamp -= cut.to - cut.from;
    rest.push_back(pose);
  }
  return rest;
}

std::string seconds_or(const std::optional<Nanoseconds>& stamp, Nanoseconds from) {
  return stamp ? fmt::format("{:.2f} s", common::to_seconds(*stamp - from)) : "never";
}

void judge_carry(BarTable& table, const std::string& name, const RunSummary& summary, const Judge& judge,
                 const Carry& carry, Nanoseconds next, bool has_bar) {
  const Nanoseconds start = first_estimate(summary, carry.to);
  const auto lost = judge.first_verdict(PoseSource::kFused, {fusion::Verdict::kLost}, start, next);
  // A pose from before the carry may be near the place after it by chance: what counts is said after the doubt.
  const auto right = judge.first_right(lost.value_or(start));
  const bool is_found = right && *right < next;
  const double driven = is_found ? judge.driven(start, *right) : NAN;
  // What odometry made at the time of that scan or image was said before it came.
  const long wrong = judge.wrong(start + 1, next);
  const std::string measured =
      fmt::format("{}; {}, {:.2f} m; {} ({:.3f} m)", seconds_or(lost, start),
                  is_found ? seconds_or(right, start) : "never", driven, wrong, judge.worst(start + 1, next));
  if (!has_bar) return table.show(name, measured);
  const bool soon = lost && common::to_seconds(*lost - start) <= 2.0;
  const bool again = is_found && common::to_seconds(*right - start) <= 5.0 && driven <= 2.0;
  table.judge(name, "2 s; 5 s, 2 m; 0", measured, soon && again && wrong == 0);
}

/// One localisation run with both carries, and one for each with its silence cut out.
void measure_arm(BarTable& table, const std::string& name, const FusionRun& plan, const FinishedMap& map,
                 const std::vector<Carry>& carries, bool has_bar) {
  const bool visual_only = plan.request.modules == std::vector<std::string>{"visual"};
  const common::Similarity2& T_truth_map = visual_only ? map.T_truth_visual : map.T_truth_map;
  const auto truth = common::read_ground_truth(plan.request.recording);
  if (!truth) return table.judge(name, "truth", truth.error().message, false);
  const auto summary = run(plan);
  if (!summary) return table.show(name, summary.error().message);
  const Judge judge(*summary, T_truth_map, *truth);
  for (std::size_t n = 0; n < carries.size(); ++n) {
    const Nanoseconds next = n + 1 < carries.size() ? carries[n + 1].from : summary->last_stamp;
    judge_carry(table, fmt::format("{}, carry {}", name, n + 1), *summary, judge, carries[n], next, has_bar);
    if (!has_bar) continue;
    FusionRun cut = plan;
    cut.cut_from = carries[n].from;
    cut.cut_to = carries[n].to;
    cut.request.to = common::to_seconds(next - (carries[n].to - carries[n].from) - summary->first_stamp);
    const auto shortened = run(cut);
    if (!shortened) {
      table.judge(name, "runs", shortened.error().message, false);
      continue;
    }
    const Judge of_cut(*shortened, T_truth_map, without(*truth, carries[n]));
    judge_carry(table, fmt::format("{}, carry {}, silence cut out", name, n + 1), *shortened, of_cut,
                {carries[n].from, carries[n].from}, shortened->last_stamp, has_bar);
  }
  if (!has_bar) return;
  const Nanoseconds first = judge.first_right(0).value_or(summary->last_stamp);
  table.judge(name + ", wrong while TRACKING, whole run", "0",
              fmt::format("{} (found after {:.1f} s)", judge.wrong(0, summary->last_stamp),
                          common::to_seconds(first - summary->first_stamp)),
              judge.wrong(0, summary->last_stamp) == 0);
}

/// The same silence as that of a carry, but without one: nothing may be called lost.
void measure_silence(BarTable& table, const std::string& name, FusionRun plan, const FinishedMap& map, double from) {
  plan.fault = SensorFault{FaultKind::kSilenced, {"laser", "cam"}, from, from + 3.0};
  plan.request.to = from + 8.0;
  const auto summary = run(plan);
  if (!summary) return table.judge(name, "runs", summary.error().message, false);
  const Judge judge(*summary, map.T_truth_map, summary->truth);
  const Nanoseconds start = summary->first_stamp + common::from_seconds(from);
  const auto lost = judge.first_verdict(PoseSource::kFused, {fusion::Verdict::kLost}, start, summary->last_stamp);
  table.judge(name, "no LOST", lost ? "LOST after " + seconds_or(lost, start) : "none", !lost);
}

void measure_carries(BarTable& table, const fs::path& sim, std::uint64_t seed, const fs::path& scratch) {
  struct Case {
    std::string name;
    fs::path mapping;
    double mapping_to;
    fs::path recording;
    double quiet;  // [s] from where for 8 s it drives on, far from a carry
  };
  for (const Case& c : {Case{"flat_second_visit", sim / "flat", 1e6, sim / "flat_second_visit", 48.0},
                        Case{"twin_rooms", sim / "twin_rooms", 81.1, sim / "twin_rooms", 60.0}}) {
    const auto map = make_map(c.mapping, c.mapping_to, seed, scratch / c.name);
    if (!map) {
      table.judge(c.name, "a map", map.error().message, false);
      continue;
    }
    FusionRun plan;
    plan.request.recording = c.recording;
    plan.request.mode = service::RunMode::kLocalization;
    plan.request.map = map->folder;
    plan.request.threads = 2;
    plan.request.seed = seed;
    const auto carries = carries_of(c.recording);
    measure_arm(table, c.name + ", fused", plan, *map, carries, true);
    measure_silence(table, c.name + ", 3 s of silence", plan, *map, c.quiet);
    for (const char* module : {"laser", "visual"}) {
      FusionRun arm = plan;
      arm.request.modules = {module};
      measure_arm(table, fmt::format("{}, {} only", c.name, module), arm, *map, carries, false);
    }
    if (c.name != "flat_second_visit") continue;
    const auto summary = run(plan);
    if (!summary) continue;
    const Judge judge(*summary, map->T_truth_map, summary->truth);
    table.at_most("walking people: error while TRACKING, rms [m]", judge.rms(0, summary->last_stamp), 0.10);
    const auto start = judge.first_right(0).value_or(0);
    const auto lost = judge.first_verdict(PoseSource::kFused, {fusion::Verdict::kLost}, start, carries.front().from);
    const auto found = judge.first_right(carries.back().to + 6 * common::kNanosecondsPerSecond);
    const auto later = judge.first_verdict(PoseSource::kFused, {fusion::Verdict::kLost},
                                           found.value_or(summary->last_stamp), summary->last_stamp);
    table.judge("walking people: false LOST", "none", lost || later ? "LOST" : "none", !lost && !later);
  }
}

/// A drive on which one half breaks for ten seconds.
struct BrokenDrive {
  std::string name;
  double from;  // [s]
  std::string donor;
};

/// The largest excess of the fused pose's error over its bar from `from` to `until`; the error is what it is off more
/// than at `from`, in the frame that fits the path before.
struct Excess {
  double error = 0.0;  // [m] where the excess is largest
  double bar = 0.0;    // [m] there
};

std::optional<Excess> largest_excess(const RunSummary& summary, Nanoseconds from, Nanoseconds until) {
  const auto fused = trajectory_of(summary, "fused");
  const auto fit = fit_to_truth(between(fused, 0, from), summary.truth);
  if (!fit) return std::nullopt;
  std::optional<Eigen::Vector2d> at_start;
  std::optional<Excess> largest;
  for (const auto& pose : between(fused, from, until)) {
    const auto truth = common::pose_at(summary.truth, pose.stamp, common::kNanosecondsPerSecond / 10);
    if (!truth) continue;
    const Eigen::Vector2d off = *fit * pose.pose.translation() - truth->translation();
    if (!at_start) at_start = off;
    const double bar = 0.15 + 0.02 * common::path_length(between(summary.truth, from, pose.stamp));
    const Excess excess{(off - *at_start).norm(), bar};
    if (!largest || excess.error - excess.bar > largest->error - largest->bar) largest = excess;
  }
  return largest;
}

void measure_fault(BarTable& table, const std::string& name, const FusionRun& plan, PoseSource half) {
  const auto summary = run(plan);
  if (!summary) return table.judge(name, "runs", summary.error().message, false);
  const Nanoseconds start = summary->first_stamp;
  const Nanoseconds from = start + common::from_seconds(plan.fault->from);
  const Nanoseconds to = start + common::from_seconds(plan.fault->to);
  const auto excess = largest_excess(*summary, from, summary->last_stamp);
  const Judge judge(*summary, {}, summary->truth);
  const auto doubted = judge.first_verdict(half, {fusion::Verdict::kSuspect, fusion::Verdict::kLost}, from, to);
  const auto lost = judge.first_verdict(PoseSource::kFused, {fusion::Verdict::kLost}, from, summary->last_stamp);
  const auto again = judge.first_verdict(half, {fusion::Verdict::kTracking}, to, summary->last_stamp);
  const bool stays = excess && excess->error <= excess->bar;
  const bool told = doubted && common::to_seconds(*doubted - from) <= 2.0;
  table.judge(
      name, "0.15 m + 2 %; 2 s",
      fmt::format("{:.3f} of {:.3f} m; {}{}; again {}", excess ? excess->error : NAN, excess ? excess->bar : NAN,
                  seconds_or(doubted, from), lost ? "; LOST" : "", seconds_or(again, to)),
      stays && told && !lost);
}

void measure_faults(BarTable& table, const fs::path& sim, std::uint64_t seed, const std::string& part,
                    const fs::path& scratch) {
  const std::vector<BrokenDrive> drives = {{"flat", 60.0, "corridor"},
                                           {"corridor", 60.0, "flat"},
                                           {"twin_rooms", 60.0, "flat"},
                                           {"weak_sensors", 60.0, "flat"},
                                           {"flat_second_visit", 46.0, "twin_rooms"}};
  for (const BrokenDrive& drive : drives) {
    FusionRun plan;
    plan.request.recording = sim / drive.name;
    plan.request.threads = 2;
    plan.request.seed = seed;
    plan.request.to = drive.from + 17.0;
    plan.donor = sim / drive.donor;
    if (drive.name == "flat_second_visit") {
      const auto map = make_map(sim / "flat", 1e6, seed, scratch / "faults");
      if (!map) return table.judge(drive.name, "a map", map.error().message, false);
      plan.request.mode = service::RunMode::kLocalization;
      plan.request.map = map->folder;
    }
    for (const FaultKind kind : {FaultKind::kSilenced, FaultKind::kFrozen, FaultKind::kReplaced}) {
      for (const auto& [half, sensor] :
           {std::pair{PoseSource::kLaser, "laser"}, std::pair{PoseSource::kVisual, "cam"}}) {
        plan.fault = SensorFault{kind, {sensor}, drive.from, drive.from + 10.0};
        const std::string name = fmt::format("{}, {} {}", drive.name, common::to_string(half), to_string(kind));
        if (name.find(part) != std::string::npos) measure_fault(table, name, plan, half);
      }
    }
  }
}

int measure(const std::string& only, std::uint64_t seed, const std::string& part) {
  BarTable table(only);
  table.print_head();
  const char* folder = std::getenv("SLAMFUSE_RECORDINGS");
  if (folder == nullptr) {
    table.skip("everything", "SLAMFUSE_RECORDINGS not set");
    return EXIT_FAILURE;
  }
  const fs::path sim = fs::path(folder) / "sim";
  const fs::path scratch = fs::temp_directory_path() / fmt::format("slamfuse_recovery_{}", getpid());
  if (table.wants("carries")) measure_carries(table, sim, seed, scratch);
  if (table.wants("faults")) measure_faults(table, sim, seed, part, scratch);
  fs::remove_all(scratch);
  return table.exit_status();
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) {
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  return slamfuse::measure(argc > 1 ? argv[1] : "", seed, argc > 3 ? argv[3] : "");
}
