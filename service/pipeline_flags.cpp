// SPDX-License-Identifier: BSD-3-Clause
#include "service/pipeline_flags.hpp"

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "service/flag_values.hpp"

namespace slamfuse::service {
namespace {

/// As many as there are processors, more only cost memory, but `fewest` at least.
int threads_from(int fewest) {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), fewest, kMaxThreads);
}

/// What --visual-odometry off means: a motion that needs none, the configured one if it is such.
void withhold_odometry(visual_slam::MotionOptions& motion) {
  if (motion.model != visual_slam::MotionModelKind::kOdometry) return;
  motion.model = visual_slam::MotionModelKind::kConstantVelocity;
}

}  // namespace

using common::Result;

void PipelineFlags::add_to(CLI::App& command, RunRequest& run) {
  configuration_.add_to(command);
  command
      .add_option("--mode", mode_,
                  "slam: make a map; localization: laser and visual SLAM find themselves in --map, which stays as it "
                  "is; without landmarks in it visual SLAM makes a new map of its own that is aligned to it")
      ->check(CLI::IsMember({"slam", "localization"}))
      ->capture_default_str();
  command.add_option("--map", map_,
                     "Map bundle of an earlier run, to continue its maps or to localise in them; localization takes a "
                     "map of Nav2 as well (its YAML file, or its folder)");
  command.add_option("--modules", run.modules, "Which halves run: laser,visual (default: all with a sensor)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"laser", "visual"}));
  command.add_option("--visual-odometry", visual_odometry_, "off: visual SLAM runs without wheel odometry")
      ->check(CLI::IsMember({"on", "off"}));
  command.add_option("--seed", run.seed, "Seed of everything random")->check(whole_number())->capture_default_str();
}

Result<void> PipelineFlags::apply_to(RunRequest& run) const {
  if (mode_ == "localization") {
    if (!map_) return common::usage_error("--mode localization: needs the --map to localise in");
    run.mode = RunMode::kLocalization;
  }
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  run.configuration = std::move(*configuration);
  if (visual_odometry_ == "off") withhold_odometry(run.configuration.visual.motion);
  if (map_) run.map = *map_;
  return {};
}

RunFlags::RunFlags(CLI::App& app) : command_(app.add_subcommand("run", "Laser and visual SLAM side by side, fused")) {
  request_.threads = threads_from(1);
  command_
      ->add_option("RECORDING", request_.recording,
                   "EuRoC/ASL folder, ROS 2 or ROS 1 bag, CARMEN log, MRPT rawlog or folder of images")
      ->required();
  command_->add_option("-o,--out", request_.out, "Folder for the results")->required();
  pipeline_.add_to(*command_, request_);
  recording_.add_to(*command_);
  command_->add_option("--cameras", request_.cameras, "Cameras to use, e.g. cam0,cam1 (default: all)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command_->add_option("--from", request_.from, "Start this many seconds into the recording")->check(finite_from(0.0));
  command_->add_option("--to", to_, "End this many seconds into the recording")->check(finite_from(0.0));
  command_->add_option("--threads", request_.threads, "Threads to work with; the result is the same (default: all)")
      ->check(CLI::Range(1, kMaxThreads));
  command_->add_option("--arrival-delay", arrival_delay_, "SENSOR=S: its messages arrive S seconds late; repeatable")
      ->allow_extra_args(false);
  command_->add_option("--stamp-offset", stamp_offset_, "SENSOR=S: its stamps are falsified by S seconds; repeatable")
      ->allow_extra_args(false);
  command_
      ->add_option("--sweep-duration", sweep_duration_,
                   "SENSOR=S: a sweep of this laser takes S seconds, whatever the recording says; negative: its last "
                   "beam is fired first; repeatable")
      ->allow_extra_args(false);
  command_->add_flag("--dds", request_.dds, "Publish pose, map and tf as ROS 2 topics while running");
  command_->add_option("--rate", request_.rate, "Recording seconds in a second; 0: as fast as possible")
      ->check(finite_from(0.0));
}

Result<CommandRequest> RunFlags::request() {
  if (const auto applied = pipeline_.apply_to(request_); !applied) return tl::unexpected(applied.error());
  auto delay = parse_seconds_by_sensor("--arrival-delay", arrival_delay_, 0.0);
  if (!delay) return tl::unexpected(delay.error());
  auto offset = parse_seconds_by_sensor("--stamp-offset", stamp_offset_, -HUGE_VAL);
  if (!offset) return tl::unexpected(offset.error());
  auto sweep = parse_seconds_by_sensor("--sweep-duration", sweep_duration_, -HUGE_VAL);
  if (!sweep) return tl::unexpected(sweep.error());
  auto recording = recording_.read();
  if (!recording) return tl::unexpected(recording.error());
  request_.recording_options = std::move(*recording);
  request_.sweep_duration = std::move(*sweep);
  request_.arrival_delay = std::move(*delay);
  request_.stamp_offset = std::move(*offset);
  request_.to = to_;
  return request_;
}

ServeFlags::ServeFlags(CLI::App& app)
    : command_(app.add_subcommand("serve", "The service: laser and visual SLAM, fused, on a robot's ROS 2 topics")) {
  command_->add_option("-o,--out", request_.run.out, "Folder for the map and, at the end, all results")->required();
  pipeline_.add_to(*command_, request_.run);
  recording_.add_to(*command_);
  command_
      ->add_option("--readout", readout_,
                   "CAMERA=S: from the first row to the last of a rolling shutter, which camera_info cannot tell; "
                   "repeatable")
      ->allow_extra_args(false);
}

Result<CommandRequest> ServeFlags::request() {
  if (const auto applied = pipeline_.apply_to(request_.run); !applied) return tl::unexpected(applied.error());
  auto readout = parse_seconds_by_sensor("--readout", readout_, 0.0);
  if (!readout) return tl::unexpected(readout.error());
  auto recording = recording_.read();
  if (!recording) return tl::unexpected(recording.error());
  request_.run.threads = threads_from(2);  // a live pipeline has no use for fewer
  request_.source.inbox.topics = std::move(recording->topics);
  request_.source.readout = std::move(*readout);
  if (!recording->base_frame.empty()) request_.source.base_frame = recording->base_frame;
  return request_;
}

}  // namespace slamfuse::service
