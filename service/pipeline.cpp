// SPDX-License-Identifier: BSD-3-Clause
#include "service/pipeline.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <variant>

#include "service/bounded_queue.hpp"
#include "service/command_path.hpp"
#include "service/external_poses.hpp"
#include "service/input_numbering.hpp"
#include "service/merge_stage.hpp"
#include "service/merge_window.hpp"
#include "service/pacer.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;

/// What may wait for a busy module in a live run, where nobody may wait for it: of scans and images the backlog, and
/// the odometry of many seconds between them.
constexpr std::size_t kLiveQueue = 4096;

bool is_live(const PipelineOptions& options) { return options.live_backlog > 0; }

/// Between what the fusion handles and its commands, with so many modules. Live, one module must not wait for the
/// outputs that all others owe.
SequenceIndex command_delay(const PipelineOptions& options, std::size_t modules) {
  const SequenceIndex delay = options.command_delay;
  if (!is_live(options) || modules == 0) return delay;
  return std::max(delay, static_cast<SequenceIndex>(modules - 1) * options.live_backlog + 1);
}

/// Steps that may wait for the fusion; live, those that wait for busy modules take none of their room.
std::size_t window_capacity(const PipelineOptions& options, std::size_t modules) {
  return options.queue_capacity + modules * static_cast<std::size_t>(options.live_backlog);
}

/// Inputs that may wait for a module.
std::size_t lane_capacity(const PipelineOptions& options) {
  return is_live(options) ? std::max(options.queue_capacity, kLiveQueue) : options.queue_capacity;
}

/// The stages of a run, the same for one thread and for many.
struct Stages {
  Stages(const PipelineParts& parts, const PipelineOptions& options)
      : inputs(*parts.recording),
        pacer(options.rate),
        commands(command_delay(options, parts.modules.size())),
        merge(*parts.fusion, commands, *parts.observer, options.most_kept, parts.requests) {
    for (const auto& module : parts.modules) {
      modules.emplace_back(module, ModuleIntervals{options.map_interval, options.checkpoint_interval},
                           options.most_kept, parts.requests);
    }
  }

  InputNumbering inputs;
  Pacer pacer;
  std::deque<ModuleStage> modules;  // stays in place: the threads refer to it
  CommandPath commands;
  MergeStage merge;
};

/// How many messages the reader rejected, by the source they would have gone to.
using RejectedByReader = std::map<PoseSource, std::size_t>;

PipelineOutcome outcome_of(const Stages& stages, const RejectedByReader& rejected, bool interrupted) {
  PipelineOutcome outcome;
  outcome.interrupted = interrupted;
  for (const auto& stage : stages.modules) outcome.counters[stage.source()] = stage.counters();
  outcome.counters[PoseSource::kFused] = stages.merge.counters();
  for (const auto& [source, count] : rejected) {
    const auto found = outcome.counters.find(source);
    if (found == outcome.counters.end()) continue;
    found->second.inputs += count;
    found->second.rejected += count;
  }
  return outcome;
}

/// Whose input a message was that the reader rejected: scans are the laser module's, images the visual module's,
/// odometry the fusion's.
PoseSource consumer_of(const common::RejectedMessage& message, const common::RecordingInfo& info) {
  const auto sensor = info.sensors.find(message.sensor);
  if (sensor == info.sensors.end()) return PoseSource::kFused;
  switch (sensor->second.kind) {
    case common::SensorKind::kLaser:
      return PoseSource::kLaser;
    case common::SensorKind::kCamera:
      return PoseSource::kVisual;
    case common::SensorKind::kPose:
      return message.sensor == kVisualPose ? PoseSource::kVisual : PoseSource::kLaser;
    case common::SensorKind::kOdometry:
    case common::SensorKind::kImu:
      break;
  }
  return PoseSource::kFused;
}

common::Result<PipelineOutcome> run_in_one_thread(const PipelineParts& parts, const PipelineOptions& options,
                                                  const std::atomic<bool>& stop) {
  Stages stages(parts, options);
  RejectedByReader rejected;
  while (!stop) {
    auto input = stages.inputs.next();
    if (!input) return tl::unexpected(input.error());
    if (!*input) break;
    MergedStep& step = (*input)->step;
    stages.pacer.wait_for(step.stamp, stop);
    if (step.rejected) ++rejected[consumer_of(*step.rejected, parts.recording->info())];
    for (auto& module : stages.modules) {
      if (!(*input)->message || !module.wants((*input)->message->message)) continue;
      const auto commands = stages.commands.await(module.source(), *(*input)->message);
      step.outputs[module.source()] = module.process(*(*input)->message, *commands);
    }
    stages.merge.handle(step);
  }
  stages.merge.finish();
  return outcome_of(stages, rejected, stop);
}

/// A run with a thread for each module and one for the fusion; the calling thread reads.
class ThreadedRun {
 public:
  ThreadedRun(const PipelineParts& parts, const PipelineOptions& options, const std::atomic<bool>& stop)
      : parts_(parts),
        options_(options),
        stop_(stop),
        stages_(parts, options),
        window_(window_capacity(options, parts.modules.size()),
                is_live(options) ? MergeOrder::kAsComplete : MergeOrder::kByIndex) {
    for (std::size_t i = 0; i < stages_.modules.size(); ++i) lanes_.emplace_back(lane_capacity(options));
  }

  common::Result<PipelineOutcome> run() {
    {
      std::jthread watcher([this](const std::stop_token& done) { watch_for_stop(done); });
      std::vector<std::jthread> workers;
      for (std::size_t i = 0; i < stages_.modules.size(); ++i) {
        workers.emplace_back(guarded([this, i] { run_module(stages_.modules[i], lanes_[i]); }));
      }
      workers.emplace_back(guarded([this] { run_merge(); }));
      guarded([this] { read(); })();
    }
    if (error_) return tl::unexpected(*error_);
    stages_.merge.finish();
    PipelineOutcome outcome = outcome_of(stages_, rejected_, stop_);
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      ModuleCounters& counters = outcome.counters.at(stages_.modules[i].source());
      counters.inputs += lanes_[i].dropped;
      counters.dropped += lanes_[i].dropped;
    }
    return outcome;
  }

 private:
  /// The way to one module.
  struct Lane {
    explicit Lane(std::size_t capacity) : queue(capacity) {}
    /// For another message, which must not wait; of scans and images so many may be under way.
    bool has_room(bool exteroceptive, int most) const {
      return queue.size() < queue.capacity() && (!exteroceptive || backlog < most);
    }
    BoundedQueue<std::shared_ptr<const NumberedMessage>> queue;
    std::atomic<int> backlog = 0;  // scans or images in the queue or being processed
    std::size_t dropped = 0;       // by the reading thread only
  };

  void read() {
    while (!stop_) {
      auto input = stages_.inputs.next();
      if (!input) return fail(input.error());
      if (!*input) break;
      stages_.pacer.wait_for((*input)->step.stamp, stop_);
      if (!distribute(std::move(**input))) return;
    }
    for (auto& lane : lanes_) lane.queue.close();
    window_.close();
  }

  bool distribute(NumberedInput input) {
    if (input.step.rejected) {
      ++rejected_[consumer_of(*input.step.rejected, parts_.recording->info())];
      return window_.open(std::move(input.step), {});
    }
    const bool exteroceptive = ModuleStage::is_exteroceptive(input.message->message);
    std::set<PoseSource> receivers;
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      const ModuleStage& module = stages_.modules[i];
      if (!module.wants(input.message->message)) continue;
      if (is_live(options_) && !lanes_[i].has_room(exteroceptive, options_.live_backlog)) {
        if (exteroceptive) ++lanes_[i].dropped;
        input.step.dropped_of = common::sensor_of(input.message->message);
      } else {
        receivers.insert(module.source());
      }
    }
    // Live, odometry goes on to the fusion at once: modules make no pose of it.
    const bool wait_for_nobody = is_live(options_) && !exteroceptive;
    if (!window_.open(std::move(input.step), wait_for_nobody ? std::set<PoseSource>() : receivers)) return false;
    for (std::size_t i = 0; i < lanes_.size(); ++i) {
      if (!receivers.contains(stages_.modules[i].source())) continue;
      if (exteroceptive) ++lanes_[i].backlog;
      if (!lanes_[i].queue.push(input.message)) return false;
    }
    return true;
  }

  void run_module(ModuleStage& module, Lane& lane) {
    while (const auto input = lane.queue.pop()) {
      const auto commands = stages_.commands.await(module.source(), **input);
      if (!commands) return;
      window_.complete((*input)->index, module.source(), module.process(**input, *commands));
      if (ModuleStage::is_exteroceptive((*input)->message)) --lane.backlog;
    }
  }

  void run_merge() {
    while (const auto step = window_.take()) stages_.merge.handle(*step);
  }

  /// A blocked thread cannot see the stop flag, so somebody must wake it up.
  void watch_for_stop(const std::stop_token& done) {
    constexpr std::chrono::milliseconds kPoll{20};
    while (!done.stop_requested() && !stop_) std::this_thread::sleep_for(kPoll);
    if (stop_) abort();
  }

  /// No exception leaves a thread: it becomes the error of the run.
  std::function<void()> guarded(std::function<void()> work) {
    return [this, work = std::move(work)] {
      try {
        work();
      } catch (const std::exception& exception) {
        fail({common::ErrorKind::kFailed, exception.what()});
      } catch (...) {
        fail({common::ErrorKind::kFailed, "unknown exception"});
      }
    };
  }

  void fail(const common::Error& error) {
    {
      const std::lock_guard lock(error_mutex_);
      if (!error_) error_ = error;
    }
    abort();
  }

  void abort() {
    for (auto& lane : lanes_) lane.queue.abort();
    window_.abort();
    stages_.commands.abort();
  }

  const PipelineParts& parts_;
  const PipelineOptions& options_;
  const std::atomic<bool>& stop_;
  Stages stages_;
  std::deque<Lane> lanes_;  // one a module, in the order of stages_.modules
  MergeWindow window_;
  RejectedByReader rejected_;  // by the reading thread only
  std::mutex error_mutex_;
  std::optional<common::Error> error_;
};

}  // namespace

common::Result<PipelineOutcome> run_pipeline(const PipelineParts& parts, const PipelineOptions& options,
                                             const std::atomic<bool>& stop) {
  if (options.threads > 1) return ThreadedRun(parts, options, stop).run();
  try {
    return run_in_one_thread(parts, options, stop);
  } catch (const std::exception& exception) {
    return common::failed(exception.what());
  } catch (...) {
    return common::failed("unknown exception");
  }
}

}  // namespace slamfuse::service
