// SPDX-License-Identifier: BSD-3-Clause
#include "service/command_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/config.hpp"
#include "service/metrics.hpp"

namespace slamfuse::service {
namespace {

using common::Result;

/// More threads than this are a typing error.
constexpr int kMaxThreads = 256;

/// The flags that choose the configuration, shared by several commands.
struct ConfigurationFlags {
  std::string file;
  std::vector<std::string> settings;

  void add_to(CLI::App& command) {
    command.add_option("--config", file, "YAML file with options; `slamfuse options` prints them all");
    command.add_option("--set", settings, "One option, after --config: KEY=VALUE, e.g. laser.particles=50; repeatable")
        ->allow_extra_args(false);
  }

  Result<Configuration> read() const {
    Configuration configuration;
    const auto describe = [&configuration](common::OptionVisitor& visit) { configuration.describe(visit); };
    if (!file.empty()) {
      if (auto done = common::read_options(file, describe); !done) return tl::unexpected(done.error());
    }
    for (const auto& setting : settings) {
      if (auto done = common::set_option(setting, describe); !done) return tl::unexpected(done.error());
    }
    return configuration;
  }
};

/// "SENSOR=SECONDS" texts as a map.
Result<std::map<std::string, double>> parse_seconds_by_sensor(const char* flag, const std::vector<std::string>& texts,
                                                              double smallest) {
  std::map<std::string, double> seconds;
  for (const auto& text : texts) {
    const std::size_t equals = text.rfind('=');
    double value = 0.0;
    const bool good = equals != std::string::npos && equals > 0 &&
                      CLI::detail::lexical_cast(text.substr(equals + 1), value) && std::isfinite(value) &&
                      value >= smallest;
    if (!good) {
      return common::usage_error(
          fmt::format("{} {}: must be SENSOR=SECONDS{}", flag, text, smallest >= 0.0 ? ", not negative" : ""));
    }
    if (!seconds.emplace(text.substr(0, equals), value).second) {
      return common::usage_error(fmt::format("{} {}: the sensor was given twice", flag, text));
    }
  }
  return seconds;
}

/// What the user tells of a recording, shared by several commands.
struct RecordingFlags {
  std::vector<std::string> topics;
  std::string base_frame;

  void add_to(CLI::App& command) {
    command
        .add_option("--topic", topics,
                    "SENSOR=TOPIC of a ROS bag or of the robot, e.g. laser0=/front/scan, odom0=/tf, truth=/mocap/pose; "
                    "`none` leaves "
                    "it out; repeatable")
        ->allow_extra_args(false);
    command.add_option("--base-frame", base_frame, "Frame of the robot (default: base_link or, in a bag, alike)");
  }

  Result<common::RecordingOptions> read() const {
    common::RecordingOptions options;
    options.base_frame = base_frame;
    for (const auto& text : topics) {
      const std::size_t equals = text.find('=');
      if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
        return common::usage_error(fmt::format("--topic {}: must be SENSOR=TOPIC", text));
      }
      if (!options.topics.emplace(text.substr(0, equals), text.substr(equals + 1)).second) {
        return common::usage_error(fmt::format("--topic {}: the sensor was given twice", text));
      }
    }
    return options;
  }
};

/// A finite number from `smallest` on; CLI11's own range check lets NaN pass.
CLI::Validator finite_from(double smallest) {
  return CLI::Validator(
      [smallest](const std::string& text) {
        double value = 0.0;
        if (CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value >= smallest) return std::string();
        return fmt::format("{} is not a number from {} on", text, smallest);
      },
      fmt::format("FLOAT >= {}", smallest));
}

/// A seed; CLI11 would take -1 for the largest number there is.
CLI::Validator whole_number() {
  return CLI::Validator(
      [](const std::string& text) {
        const bool good =
            !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
        return good ? std::string() : text + " is not a whole number from 0 on";
      },
      "UINT");
}

/// What --visual-odometry off means: a motion that needs none, the configured one if it is such.
void withhold_odometry(visual_slam::MotionOptions& motion) {
  if (motion.model != visual_slam::MotionModelKind::kOdometry) return;
  motion.model = visual_slam::MotionModelKind::kConstantVelocity;
}

class RunFlags {
 public:
  explicit RunFlags(CLI::App& app) : command_(app.add_subcommand("run", "Laser and visual SLAM side by side, fused")) {
    command_
        ->add_option("RECORDING", request_.recording,
                     "EuRoC/ASL folder, ROS 2 or ROS 1 bag, CARMEN log, MRPT rawlog or folder of images")
        ->required();
    command_->add_option("-o,--out", request_.out, "Folder for the results")->required();
    configuration_.add_to(*command_);
    recording_.add_to(*command_);
    command_
        ->add_option(
            "--mode", mode_,
            "slam: make a map; localization: laser and visual SLAM find themselves in --map, which stays as it "
            "is; without landmarks in it visual SLAM makes a new map of its own that is aligned to it")
        ->check(CLI::IsMember({"slam", "localization"}))
        ->capture_default_str();
    command_->add_option("--map", map_,
                         "Map bundle of an earlier run, to continue its maps or to localise in them; localization "
                         "takes a map of Nav2 as well (its YAML file, or its folder)");
    command_->add_option("--modules", request_.modules, "Which halves run: laser,visual (default: all with a sensor)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"laser", "visual"}));
    command_->add_option("--cameras", request_.cameras, "Cameras to use, e.g. cam0,cam1 (default: all)")
        ->delimiter(',')
        ->allow_extra_args(false);
    command_->add_option("--visual-odometry", visual_odometry_, "off: visual SLAM runs without wheel odometry")
        ->check(CLI::IsMember({"on", "off"}));
    command_->add_option("--from", request_.from, "Start this many seconds into the recording")
        ->check(finite_from(0.0));
    command_->add_option("--to", to_, "End this many seconds into the recording")->check(finite_from(0.0));
    command_->add_option("--threads", request_.threads, "Threads to work with; the result is the same (default: all)")
        ->check(CLI::Range(1, kMaxThreads));
    command_->add_option("--seed", request_.seed, "Seed of everything random")
        ->check(whole_number())
        ->capture_default_str();
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

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    if (mode_ == "localization") {
      if (!map_) return common::usage_error("--mode localization: needs the --map to localise in");
      request_.mode = RunMode::kLocalization;
    }
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
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
    request_.configuration = *configuration;
    if (visual_odometry_ == "off") withhold_odometry(request_.configuration.visual.motion);
    request_.arrival_delay = *delay;
    request_.stamp_offset = *offset;
    request_.to = to_;
    if (map_) request_.map = *map_;
    return request_;
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  RecordingFlags recording_;
  RunRequest request_ = with_all_threads();
  std::string mode_ = "slam";
  std::optional<std::string> map_;
  std::string visual_odometry_ = "on";
  std::optional<double> to_;
  std::vector<std::string> arrival_delay_;
  std::vector<std::string> stamp_offset_;
  std::vector<std::string> sweep_duration_;

  static RunRequest with_all_threads() {
    RunRequest request;
    request.threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
    return request;
  }
};

/// More threads than processors only cost memory; a live pipeline has no use for fewer than two.
int all_threads() { return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 2, kMaxThreads); }

class ServeFlags {
 public:
  explicit ServeFlags(CLI::App& app)
      : command_(app.add_subcommand("serve", "The service: laser and visual SLAM, fused, on a robot's ROS 2 topics")) {
    command_->add_option("-o,--out", request_.run.out, "Folder for the map and, at the end, all results")->required();
    configuration_.add_to(*command_);
    recording_.add_to(*command_);
    command_->add_option("--mode", mode_, "slam: make a map; localization: the laser finds itself in --map")
        ->check(CLI::IsMember({"slam", "localization"}))
        ->capture_default_str();
    command_->add_option("--map", map_, "Map to continue in (a bundle) or to localise in (also a map of Nav2)");
    command_
        ->add_option("--modules", request_.run.modules, "Which halves run: laser,visual (default: all with a sensor)")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember({"laser", "visual"}));
    command_->add_option("--visual-odometry", visual_odometry_, "off: visual SLAM runs without wheel odometry")
        ->check(CLI::IsMember({"on", "off"}));
    command_
        ->add_option("--readout", readout_,
                     "CAMERA=S: from the first row to the last of a rolling shutter, which camera_info cannot tell; "
                     "repeatable")
        ->allow_extra_args(false);
    command_->add_option("--seed", request_.run.seed, "Seed of everything random")
        ->check(whole_number())
        ->capture_default_str();
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    RunRequest& run = request_.run;
    if (mode_ == "localization") {
      if (!map_) return common::usage_error("--mode localization: needs the --map to localise in");
      run.mode = RunMode::kLocalization;
    }
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
    auto readout = parse_seconds_by_sensor("--readout", readout_, 0.0);
    if (!readout) return tl::unexpected(readout.error());
    auto recording = recording_.read();
    if (!recording) return tl::unexpected(recording.error());
    run.configuration = *configuration;
    if (visual_odometry_ == "off") withhold_odometry(run.configuration.visual.motion);
    if (map_) run.map = *map_;
    run.threads = all_threads();
    request_.source.topics = std::move(recording->topics);
    request_.source.readout = std::move(*readout);
    if (!recording->base_frame.empty()) request_.source.base_frame = recording->base_frame;
    return request_;
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  RecordingFlags recording_;
  ServeRequest request_;
  std::string mode_ = "slam";
  std::optional<std::string> map_;
  std::string visual_odometry_ = "on";
  std::vector<std::string> readout_;
};

class PlayFlags {
 public:
  explicit PlayFlags(CLI::App& app) : command_(app.add_subcommand("play", "Publish a recording as ROS 2 topics")) {
    command_->add_option("RECORDING", request_.recording, "Any recording that `run` takes")->required();
    recording_.add_to(*command_);
    configuration_.add_to(*command_);
    command_->add_option("--rate", request_.rate, "Recording seconds in a second, above 0")
        ->check(finite_from(1e-3))
        ->capture_default_str();
    command_->add_option("--stamps", stamps_, "recorded: as they are; now: all moved so that the first is now")
        ->check(CLI::IsMember({"recorded", "now"}))
        ->capture_default_str();
    command_->add_option("--from", request_.from, "Start this many seconds into the recording")
        ->check(finite_from(0.0));
    command_->add_option("--to", to_, "End this many seconds into the recording")->check(finite_from(0.0));
    command_->add_option("--times", request_.times, "How often, one following on the other; 0: until stopped")
        ->check(CLI::Range(0, 1'000'000))
        ->capture_default_str();
    command_->add_option("--wait", request_.wait, "Wait at most so many seconds for listeners to every topic")
        ->check(finite_from(0.0))
        ->capture_default_str();
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
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

 private:
  CLI::App* command_;
  PlayRequest request_;
  ConfigurationFlags configuration_;
  RecordingFlags recording_;
  std::string stamps_ = "recorded";
  std::optional<double> to_;
};

class RecordFlags {
 public:
  explicit RecordFlags(CLI::App& app) : command_(app.add_subcommand("record", "Write ROS 2 topics to a ROS 2 bag")) {
    command_->add_option("-o,--out", request_.out, "Folder of the bag; must not exist")->required();
    command_->add_option("--topics", request_.topics, "Topics to record, e.g. /scan /tf (default: all that there are)");
    command_->add_option("--duration", duration_, "End after so many seconds (default: when stopped)")
        ->check(finite_from(0.0));
    configuration_.add_to(*command_);
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
    request_.network = configuration->service.dds.network;
    request_.duration = duration_;
    return request_;
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  RecordRequest request_;
  std::optional<double> duration_;
};

class CallFlags {
 public:
  explicit CallFlags(CLI::App& app) : command_(app.add_subcommand("call", "Ask a running `serve` for something")) {
    command_
        ->add_option("SERVICE", request_.service,
                     "save_map, load_map PATH, set_mode slam|localization, align_now or "
                     "reinitialize_global_localization")
        ->required();
    command_->add_option("ARGUMENT", request_.argument, "Of load_map (a path where `serve` runs) and set_mode");
    configuration_.add_to(*command_);
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
    request_.network = configuration->service.dds.network;
    return request_;
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  CallRequest request_;
};

class AlignFlags {
 public:
  explicit AlignFlags(CLI::App& app)
      : command_(app.add_subcommand("align", "Align the trajectories of any two SLAM systems")) {
    command_->add_option("LASER", request_.laser, "Trajectory in metres (TUM or `t x y theta`)")->required();
    command_->add_option("VISUAL", request_.visual, "Trajectory of any scale (TUM or `t x y theta`)")->required();
    command_->add_option("-o,--out", request_.out, "Folder for the results")->required();
    command_->add_option("--method", method_, "similarity, affine, seed004 or auto");
    command_->add_option("--seed", request_.seed, "Seed of everything random")
        ->check(whole_number())
        ->capture_default_str();
    configuration_.add_to(*command_);
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    if (!method_.empty()) configuration_.settings.push_back("fusion.alignment.method=" + method_);
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
    request_.options = configuration->fusion.alignment;
    return request_;
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  AlignRequest request_;
  std::string method_;
};

class EvaluateFlags {
 public:
  explicit EvaluateFlags(CLI::App& app)
      : command_(app.add_subcommand("evaluate", "Compare a trajectory with a reference")) {
    command_->add_option("ESTIMATE", request_.estimate, "Trajectory of base_link (TUM or `t x y theta`)")->required();
    command_->add_option("REFERENCE", reference_,
                         "Trajectory, recording with ground truth, or reference of a corrected CARMEN log");
    command_->add_option("--align", align_, "How the estimate is fitted first")
        ->check(CLI::IsMember({"se2", "sim2", "none"}))
        ->capture_default_str();
    command_->add_option("--align-as", align_as_, "EST REF: apply the transform fitted on this pair instead")
        ->expected(2);
    command_->add_option("--relations", relations_, "Relations file: the metric of Kuemmerle et al. 2009");
    command_->add_flag("--fit-offset", request_.fit_offset,
                       "The reference is of another body on the robot, by another clock (motion capture): fit one "
                       "constant offset of each as well");
    recording_.add_to(*command_);
    command_->add_flag("--json", request_.json, "Print JSON");
  }

  bool chosen() const { return command_->parsed(); }

  Result<CommandRequest> request() {
    if (reference_.empty() && relations_.empty()) {
      return common::usage_error("evaluate: give a REFERENCE, or --relations, or both");
    }
    if (!align_as_.empty() && reference_.empty()) return common::usage_error("--align-as: needs a REFERENCE");
    if (!align_as_.empty() && align_ == "none") {
      return common::usage_error("--align none: with --align-as only se2 or sim2, which say how that pair is fitted");
    }
    if (request_.fit_offset && (align_ != "se2" || !align_as_.empty())) {
      return common::usage_error("--fit-offset: only with --align se2 and without --align-as");
    }
    auto recording = recording_.read();
    if (!recording) return tl::unexpected(recording.error());
    request_.recording_options = std::move(*recording);
    if (!reference_.empty()) request_.reference = reference_;
    if (!relations_.empty()) request_.relations = relations_;
    if (!align_as_.empty()) request_.align_as = {align_as_[0], align_as_[1]};
    using common::EvaluationAlignment;
    request_.align = align_ == "sim2"   ? EvaluationAlignment::kSim2
                     : align_ == "none" ? EvaluationAlignment::kNone
                                        : EvaluationAlignment::kSe2;
    return request_;
  }

 private:
  CLI::App* command_;
  EvaluateRequest request_;
  RecordingFlags recording_;
  std::string reference_;
  std::string align_ = "se2";
  std::vector<std::string> align_as_;
  std::string relations_;
};

class InfoFlags {
 public:
  explicit InfoFlags(CLI::App& app)
      : command_(app.add_subcommand("info", "What is in a recording or in a map bundle")) {
    command_->add_option("PATH", request_.path, "Recording or map bundle")->required();
    recording_.add_to(*command_);
  }
  bool chosen() const { return command_->parsed(); }
  Result<CommandRequest> request() const {
    auto recording = recording_.read();
    if (!recording) return tl::unexpected(recording.error());
    InfoRequest request = request_;
    request.recording_options = std::move(*recording);
    return request;
  }

 private:
  CLI::App* command_;
  InfoRequest request_;
  RecordingFlags recording_;
};

class OptionsFlags {
 public:
  explicit OptionsFlags(CLI::App& app)
      : command_(app.add_subcommand("options", "Print every option with its default, unit, range and meaning")) {
    command_->add_option("--format", format_, "yaml: a file for --config; markdown: tables; text")
        ->check(CLI::IsMember({"yaml", "markdown", "text"}))
        ->capture_default_str();
    configuration_.add_to(*command_);
  }
  bool chosen() const { return command_->parsed(); }
  Result<CommandRequest> request() const {
    auto configuration = configuration_.read();
    if (!configuration) return tl::unexpected(configuration.error());
    const auto describe = [&](common::OptionVisitor& visit) { configuration->describe(visit); };
    if (format_ == "markdown") return PrintRequest{common::options_to_markdown(describe)};
    if (format_ == "text") return PrintRequest{common::options_to_help(describe)};
    return PrintRequest{common::options_to_yaml(describe)};
  }

 private:
  CLI::App* command_;
  ConfigurationFlags configuration_;
  std::string format_ = "yaml";
};

}  // namespace

Result<CommandRequest> parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Laser and visual SLAM side by side, one trusted pose out.", "slamfuse");
  app.set_version_flag("--version", std::string("slamfuse ") + program_version());
  app.require_subcommand(1);
  RunFlags run(app);
  ServeFlags serve(app);
  PlayFlags play(app);
  RecordFlags record(app);
  CallFlags call(app);
  AlignFlags align(app);
  EvaluateFlags evaluate(app);
  InfoFlags info(app);
  OptionsFlags options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app.get_subcommands();
    return PrintRequest{chosen.empty() ? app.help() : chosen.front()->help("slamfuse")};
  } catch (const CLI::CallForVersion& version) {
    return PrintRequest{std::string(version.what()) + "\n"};
  } catch (const CLI::Error& error) {
    return common::usage_error(std::string(error.what()) + "\nRun with --help for more information.");
  }
  if (run.chosen()) return run.request();
  if (serve.chosen()) return serve.request();
  if (play.chosen()) return play.request();
  if (record.chosen()) return record.request();
  if (call.chosen()) return call.request();
  if (align.chosen()) return align.request();
  if (evaluate.chosen()) return evaluate.request();
  if (info.chosen()) return info.request();
  return options.request();
}

}  // namespace slamfuse::service
