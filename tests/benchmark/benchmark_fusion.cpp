// SPDX-License-Identifier: BSD-3-Clause
// What the fusion promises on whole recordings in normal driving, measured with the pipeline of `slamfuse run`: its
// error against the better half, false alarms, consistency, the distances of seed 004's Table I, wrong stamps.
// SLAMFUSE_RECORDINGS names the folder with sim/ and real/.
//
//     benchmark_fusion [GROUP [SEED]]      only the groups whose name contains GROUP:
//                                          accuracy, alarms, distances, offsets
//
// benchmark_recovery has carries and broken sensors.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/LU>

#include "benchmark/bar_table.hpp"
#include "benchmark/fusion_run.hpp"
#include "common/angle.hpp"
#include "fusion/alignment.hpp"

namespace slamfuse {
namespace {

namespace fs = std::filesystem;
using common::PoseSource;
using common::TrackingState;

struct Drive {
  std::string name;  // below the folder of the recordings
  double to = 1e6;   // [s]; before the robot is carried
  double camera_delay = 0.0;
  double bar = 0.0;  // ATE of the fused pose [m]
};

const std::vector<Drive> kSimulated = {{"sim/flat", 1e6, 0.0, 0.03},
                                       {"sim/corridor", 1e6, 0.0, 0.25},
                                       {"sim/twin_rooms", 81.1, 0.0, 0.04},
                                       {"sim/weak_sensors", 1e6, 0.2, 0.08}};
const std::vector<Drive> kReal = {{"real/jackal/test_2026-02-17-15-54-31"},
                                  {"real/olin_neato"},
                                  {"real/radish/intel.clf.bz2"},
                                  {"real/radish/aces.clf.bz2"},
                                  {"real/radish/fr079.clf.bz2"},
                                  {"real/radish/mit-csail.clf.bz2"}};

FusionRun plan(const fs::path& recordings, const Drive& drive, std::uint64_t seed) {
  FusionRun plan;
  plan.request.recording = recordings / drive.name;
  plan.request.to = drive.to;
  plan.request.threads = 2;
  plan.request.seed = seed;
  if (drive.camera_delay > 0.0) plan.request.arrival_delay["cam0"] = drive.camera_delay;
  return plan;
}

/// Mean NEES of the fused poses (3 is right), the map's frame fitted to the truth.
double mean_nees(const service::RunSummary& summary) {
  const auto fused = trajectory_of(summary, "fused");
  const auto fit = fit_to_truth(fused, summary.truth);
  if (!fit) return NAN;
  const Eigen::Matrix3d turn = adjoint(common::Pose2{0.0, 0.0, fit->pose.theta});
  double sum = 0.0;
  double count = 0.0;
  for (const auto& estimate : summary.log.estimates.at(PoseSource::kFused)) {
    const auto truth = common::pose_at(summary.truth, estimate.stamp, common::kNanosecondsPerSecond / 10);
    if (!truth) continue;
    Eigen::Vector3d error = (*fit * estimate.pose).vector() - truth->vector();
    error.z() = common::normalize_angle(error.z());
    const Eigen::Matrix3d covariance = turn * estimate.covariance * turn.transpose();
    sum += error.dot(covariance.inverse() * error);
    count += 1.0;
  }
  return sum / count;
}

/// How often and how long the fused pose was not TRACKING after it first was.
struct Alarms {
  int lost = 0;
  double suspect_share = 0.0;
};

Alarms alarms_of(const service::RunSummary& summary) {
  Alarms alarms;
  bool found = false;
  for (const auto& entry : summary.log.status) {
    if (entry.source != PoseSource::kFused) continue;
    found = found || entry.state == fusion::Verdict::kTracking;
    if (found && entry.state == fusion::Verdict::kLost) ++alarms.lost;
  }
  const auto estimates = summary.log.estimates.find(PoseSource::kFused);
  if (estimates == summary.log.estimates.end()) return alarms;
  const auto suspects = std::count_if(estimates->second.begin(), estimates->second.end(),
                                      [](const auto& estimate) { return estimate.state != TrackingState::kTracking; });
  alarms.suspect_share = static_cast<double>(suspects) / static_cast<double>(estimates->second.size());
  return alarms;
}

void judge_alarms(BarTable& table, const std::string& name, const service::RunSummary& summary) {
  const Alarms alarms = alarms_of(summary);
  table.judge(name + ": false alarms", "0 LOST, SUSPECT <= 2 %",
              fmt::format("{} LOST, SUSPECT {:.2f} %", alarms.lost, 100.0 * alarms.suspect_share),
              alarms.lost == 0 && alarms.suspect_share <= 0.02);
}

void measure_simulated(BarTable& table, const fs::path& recordings, std::uint64_t seed) {
  for (const Drive& drive : kSimulated) {
    const auto summary = run(plan(recordings, drive, seed));
    if (!summary) {
      table.judge(drive.name, "runs", summary.error().message, false);
      continue;
    }
    const double laser = ate_of(*summary, "laser");
    const double visual = ate_of(*summary, "visual");
    const double fused = ate_of(*summary, "fused");
    table.show(drive.name + ": ATE of laser, visual, fused [m]",
               fmt::format("{:.4f}, {:.4f}, {:.4f}", laser, visual, fused));
    table.at_most(drive.name + ": fused ATE [m]", fused, drive.bar);
    table.at_most(drive.name + ": fused over the better half", fused / std::min(laser, visual), 1.05);
    table.show(drive.name + ": mean NEES (3 is right)", fmt::format("{:.2f}", mean_nees(*summary)));
    judge_alarms(table, drive.name, *summary);
  }
}

void measure_real(BarTable& table, const fs::path& recordings, std::uint64_t seed) {
  for (const Drive& drive : kReal) {
    if (!fs::exists(recordings / drive.name)) {
      table.skip(drive.name, "not in " + recordings.string());
    } else if (const auto summary = run(plan(recordings, drive, seed))) {
      judge_alarms(table, drive.name, *summary);
    } else {
      table.judge(drive.name, "runs", summary.error().message, false);
    }
  }
}

/// Relative errors of the distances between random pairs of aligned visual positions that are truly at least 2 m apart.
std::vector<double> distance_errors(const common::Trajectory2& aligned, const common::Trajectory2& truth) {
  constexpr int kDraws = 100;
  constexpr int kDistances = 6;  // in Table I of seed 004
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> places;
  for (const auto& pose : aligned) {
    const auto there = common::pose_at(truth, pose.stamp, common::kNanosecondsPerSecond / 10);
    if (there) places.emplace_back(pose.pose.translation(), there->translation());
  }
  std::vector<double> errors;
  std::mt19937_64 random(1);
  while (places.size() > 1 && errors.size() < kDraws * kDistances) {
    const auto& [estimate_a, true_a] = places[random() % places.size()];
    const auto& [estimate_b, true_b] = places[random() % places.size()];
    const double distance = (true_a - true_b).norm();
    if (distance >= 2.0) errors.push_back(std::abs((estimate_a - estimate_b).norm() / distance - 1.0));
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

void measure_distances(BarTable& table, const fs::path& recordings, std::uint64_t seed) {
  constexpr double kFitted = 80.0;  // [s] of the drive
  FusionRun flat = plan(recordings, kSimulated.front(), seed);
  flat.request.cameras = {"cam0"};
  flat.request.configuration.visual.motion.model = visual_slam::MotionModelKind::kConstantVelocity;
  const auto summary = run(flat);
  if (!summary) return table.judge("distances", "runs", summary.error().message, false);
  const common::Nanoseconds middle = summary->first_stamp + common::from_seconds(kFitted);
  for (const char* online : {"", "_final"}) {
    const auto laser = trajectory_of(*summary, std::string("laser") + online);
    const auto visual = trajectory_of(*summary, std::string("visual") + online);
    for (const auto method :
         {fusion::AlignmentMethod::kAuto, fusion::AlignmentMethod::kAffine, fusion::AlignmentMethod::kSeed004}) {
      fusion::AlignmentOptions options;
      options.method = method;
      const auto alignment = fusion::align_trajectories(between(laser, 0, middle), between(visual, 0, middle), options);
      const std::string name = fmt::format("distances: visual{}, {}", online, to_string(method));
      if (!alignment.accepted) {
        table.judge(name, "accepted", alignment.reason, false);
        continue;
      }
      const auto rest = between(visual, middle, summary->last_stamp);
      const auto errors = distance_errors(to_laser_frame(rest, alignment), summary->truth);
      if (errors.empty()) {
        table.judge(name, "positions", "none", false);
        continue;
      }
      double sum = 0.0;
      for (const double error : errors) sum += error;
      const double mean = 100.0 * sum / static_cast<double>(errors.size());
      const double high = 100.0 * errors[errors.size() * 95 / 100];
      table.judge(name, "2.0 %, 95th 4.6 %", fmt::format("{:.2f} %, 95th {:.2f} %", mean, high),
                  mean <= 2.0 && high <= 4.6);
    }
  }
}

/// What was added to the stamps of cam0 in all [s]: by the visual half, which tells it as an event, and by the fusion.
double found_offset(const service::RunSummary& summary) {
  double by_visual = 0.0;  // [ms]
  for (const auto& event : summary.log.events) {
    if (event.kind == "clock_offset") std::sscanf(event.detail.c_str(), "stamps of cam0 are moved by %lf", &by_visual);
  }
  return 1e-3 * by_visual + (summary.alignment ? summary.alignment->clock_offset : 0.0);
}

void measure_offsets(BarTable& table, const fs::path& recordings, std::uint64_t seed) {
  double without = NAN;
  for (const double offset : {0.0, -0.2, -0.1, 0.1, 0.2, 0.4}) {
    FusionRun flat = plan(recordings, kSimulated.front(), seed);
    for (const char* camera : {"cam0", "cam1"}) flat.request.stamp_offset[camera] = offset;
    const auto summary = run(flat);
    const std::string name = fmt::format("offsets: {:+.1f} s", offset);
    if (!summary) {
      table.judge(name, "runs", summary.error().message, false);
      continue;
    }
    const double fused = ate_of(*summary, "fused");
    table.show(name + ": ATE of visual, fused [m]", fmt::format("{:.4f}, {:.4f}", ate_of(*summary, "visual"), fused));
    table.judge(name + ": found within 15 ms", fmt::format("{:.0f} +- 15 ms", -1e3 * offset),
                fmt::format("{:.1f} ms", 1e3 * found_offset(*summary)),
                std::abs(found_offset(*summary) + offset) <= 0.015);
    if (offset == 0.0) {
      without = fused;
    } else {
      table.at_most(name + ": fused ATE over that without", fused / without, 1.1);
    }
  }
}

int measure(const std::string& only, std::uint64_t seed) {
  BarTable table(only);
  table.print_head();
  const char* folder = std::getenv("SLAMFUSE_RECORDINGS");
  if (folder == nullptr) {
    table.skip("everything", "SLAMFUSE_RECORDINGS not set");
    return EXIT_FAILURE;
  }
  if (table.wants("accuracy")) measure_simulated(table, folder, seed);
  if (table.wants("alarms")) measure_real(table, folder, seed);
  if (table.wants("distances")) measure_distances(table, folder, seed);
  if (table.wants("offsets")) measure_offsets(table, folder, seed);
  return table.exit_status();
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) {
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  return slamfuse::measure(argc > 1 ? argv[1] : "", seed);
}
