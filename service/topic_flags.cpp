// SPDX-License-Identifier: BSD-3-Clause
#include "service/topic_flags.hpp"

#include <utility>

#include "service/flag_values.hpp"

namespace slamfuse::service {

using common::Result;

PlayFlags::PlayFlags(CLI::App& app) : command_(app.add_subcommand("play", "Publish a recording as ROS 2 topics")) {
  command_->add_option("RECORDING", request_.recording, "Any recording that `run` takes")->required();
  recording_.add_to(*command_);
  configuration_.add_to(*command_);
  command_->add_option("--rate", request_.rate, "Recording seconds in a second, above 0")
      ->check(finite_from(1e-3))
      ->capture_default_str();
  command_->add_option("--stamps", stamps_, "recorded: as they are; now: all moved so that the first is now")
      ->check(CLI::IsMember({"recorded", "now"}))
      ->capture_default_str();
  command_->add_option("--from", request_.from, "Start this many seconds into the recording")->check(finite_from(0.0));
  command_->add_option("--to", to_, "End this many seconds into the recording")->check(finite_from(0.0));
  command_->add_option("--times", request_.times, "How often, one following on the other; 0: until stopped")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  command_->add_option("--wait", request_.wait, "Wait at most so many seconds for listeners to every topic")
      ->check(finite_from(0.0))
      ->capture_default_str();
}

Result<CommandRequest> PlayFlags::request() {
  auto recording = recording_.read();
  if (!recording) return tl::unexpected(recording.error());
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  request_.network = configuration->service.dds.network;
  request_.recording_options = std::move(*recording);
  request_.stamps = stamps_ == "now" ? PlayStamps::kNow : PlayStamps::kRecorded;
  request_.to = to_;
  return request_;
}

RecordFlags::RecordFlags(CLI::App& app) : command_(app.add_subcommand("record", "Write ROS 2 topics to a ROS 2 bag")) {
  command_->add_option("-o,--out", request_.out, "Folder of the bag; must not exist")->required();
  command_->add_option("--topics", request_.topics, "Topics to record, e.g. /scan /tf (default: all that there are)");
  command_->add_option("--duration", duration_, "End after so many seconds (default: when stopped)")
      ->check(finite_from(0.0));
  configuration_.add_to(*command_);
}

Result<CommandRequest> RecordFlags::request() {
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  request_.network = configuration->service.dds.network;
  request_.duration = duration_;
  return request_;
}

CallFlags::CallFlags(CLI::App& app) : command_(app.add_subcommand("call", "Ask a running `serve` for something")) {
  command_
      ->add_option("SERVICE", request_.service,
                   "save_map, load_map PATH, set_mode slam|localization, align_now or "
                   "reinitialize_global_localization")
      ->required();
  command_->add_option("ARGUMENT", request_.argument, "Of load_map (a path where `serve` runs) and set_mode");
  configuration_.add_to(*command_);
}

Result<CommandRequest> CallFlags::request() {
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  request_.dds = configuration->service.dds;
  return request_;
}

}  // namespace slamfuse::service
