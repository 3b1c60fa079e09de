// SPDX-License-Identifier: BSD-3-Clause
// Damages the pictures (or the wheels) of a recording for a stretch of time and prints what the visual SLAM makes of
// it: error and states while it lasts and afterwards.
//
//     benchmark_visual_damage RECORDING CAMERAS [FROM LENGTH AFTER] [only=DAMAGE] [visual.key=value ...]
//
// CAMERAS is a list such as cam0,cam1; FROM, LENGTH (default 30 and 10) and AFTER (30) are seconds. The frame is
// fitted on the poses before the damage.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "common/angle.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "visual_slam/confidence.hpp"
#include "visual_slam/input_damage.hpp"
#include "visual_slam/visual_slam.hpp"

namespace {

using namespace slamfuse;
using common::TrackingState;
using visual_slam::testing::Damage;
using visual_slam::testing::JudgedEstimate;

int fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return EXIT_FAILURE;
}

struct Window {
  common::Nanoseconds start;  // of the recording
  common::Nanoseconds from;
  common::Nanoseconds to;
};

struct Row {
  double square_sum = 0.0;
  double worst = 0.0;
  double worst_heading = 0.0;
  int poses = 0;
  int states[3] = {0, 0, 0};

  void add(const JudgedEstimate& estimate) {
    ++states[static_cast<int>(estimate.state)];
    if (estimate.state == TrackingState::kLost) return;
    ++poses;
    square_sum += estimate.position * estimate.position;
    worst = std::max(worst, estimate.position);
    worst_heading = std::max(worst_heading, estimate.heading);
  }
  void print() const {
    const int all = std::max(1, states[0] + states[1] + states[2]);
    std::printf(" %6.3f %6.3f %5.1f  %3d/%3d/%3d |", poses > 0 ? std::sqrt(square_sum / poses) : std::nan(""), worst,
                common::to_degrees(worst_heading), 100 * states[0] / all, 100 * states[1] / all, 100 * states[2] / all);
  }
};

void print_row(Damage damage, const std::vector<JudgedEstimate>& judged, const Window& window, int rejected) {
  Row during, after;
  int false_poses = 0;
  double worst_false = 0.0;
  std::optional<double> recovered;
  for (const JudgedEstimate& estimate : judged) {
    if (is_false_confidence(estimate)) {
      ++false_poses;
      worst_false = std::max(worst_false, estimate.position);
    }
    if (estimate.stamp < window.from) continue;
    (estimate.stamp < window.to ? during : after).add(estimate);
    if (!recovered && estimate.stamp >= window.to && estimate.state == TrackingState::kTracking) {
      recovered = common::to_seconds(estimate.stamp - window.to);
    }
  }
  std::printf("%-16s |", to_string(damage).c_str());
  during.print();
  after.print();
  std::printf(" %s s | %3d (%.2f m) | %d\n", recovered ? std::to_string(*recovered).substr(0, 4).c_str() : "never",
              false_poses, worst_false, rejected);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    return fail(
        "usage: benchmark_visual_damage RECORDING CAMERAS [FROM LENGTH AFTER] [only=DAMAGE] [visual.key=value ...]");
  }
  visual_slam::VisualSlamOptions options;
  std::vector<double> seconds;
  std::string only;
  for (int i = 3; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.find('=') == std::string::npos) {
      seconds.push_back(std::atof(argv[i]));
      continue;
    }
    if (argument.starts_with("only=")) {
      only = argument.substr(5);
      continue;
    }
    const auto set = common::set_option(
        argument, [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) return fail(set.error().message);
  }
  if (seconds.empty()) seconds = {30.0, 10.0, 30.0};
  if (seconds.size() != 3) return fail("FROM, LENGTH and AFTER go together");
  auto recording = common::open_recording(argv[1]);
  if (!recording) return fail(recording.error().message);
  const auto truth = common::read_ground_truth(argv[1]);
  if (!truth || truth->empty()) return fail(std::string(argv[1]) + ": no ground truth");
  std::map<std::string, common::CameraCalibration> cameras;
  std::istringstream names(argv[2]);
  for (std::string name; std::getline(names, name, ',');) {
    const auto& known = (*recording)->info().calibration.cameras;
    if (!known.contains(name)) return fail("the recording has no camera " + name);
    cameras.emplace(name, known.at(name));
  }
  const common::Nanoseconds start = (*recording)->info().first_stamp;
  const Window window{start, start + common::from_seconds(seconds[0]),
                      start + common::from_seconds(seconds[0] + seconds[1])};
  const common::Nanoseconds end = window.to + common::from_seconds(seconds[2]);

  std::vector<common::SensorMessage> messages;
  while (true) {
    auto item = (*recording)->next();
    if (!item) return fail(item.error().message);
    if (!*item) break;
    const auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message == nullptr || std::holds_alternative<common::LaserScan>(*message)) continue;
    if (common::stamp_of(*message) > end) break;
    messages.push_back(*message);
  }

  std::printf(
      "                 | during: ATE, max [m], heading [deg], T/U/L %% | after: the same | TRACKING again | "
      "falsely TRACKING (worst) | rejected\n");
  for (const Damage damage : visual_slam::testing::kAllDamages) {
    if (!only.empty() && to_string(damage) != only) continue;
    auto slam = visual_slam::VisualSlam::create(options, damaged(damage, cameras), 1, 2);
    if (!slam) return fail(slam.error().message);
    visual_slam::testing::Damager damager(damage, window.from, window.to);
    std::vector<common::PoseEstimate> estimates;
    int rejected = 0;
    for (const common::SensorMessage& message : messages) {
      if (!(*slam)->wants(message)) continue;
      for (const common::SensorMessage& arriving : damager.apply(message)) {
        const common::ProcessResult result = (*slam)->process(arriving);
        if (result.rejected) ++rejected;
        if (result.estimate) estimates.push_back(*result.estimate);
      }
    }
    print_row(damage, visual_slam::testing::judge(estimates, *truth, window.from), window, rejected);
  }
  return EXIT_SUCCESS;
}
