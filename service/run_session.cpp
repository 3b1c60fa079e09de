// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_session.hpp"

#include <algorithm>
#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>

#include "common/replay.hpp"
#include "service/map_bundle.hpp"
#include "service/map_source.hpp"
#include "service/pipeline.hpp"
#include "service/run_accuracy.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;

/// fusion::Fusion as the pipeline wants it.
class TrajectoryFusion : public FusionStage {
 public:
  explicit TrajectoryFusion(fusion::Fusion& fusion) : fusion_(fusion) {}
  fusion::FusionOutput process(const common::WheelOdometry& odometry) override { return fusion_.process(odometry); }
  fusion::FusionOutput process(const common::PoseEstimate& estimate) override { return fusion_.process(estimate); }
  fusion::FusionOutput align_now() override { return fusion_.align_now(); }
  const std::optional<fusion::Alignment>& alignment() const override { return fusion_.alignment(); }

 private:
  fusion::Fusion& fusion_;
};

/// The processed stretch of time.
class Span : public PipelineObserver {
 public:
  void on_step(common::Nanoseconds stamp) override {
    first_ = steps_ == 0 ? stamp : std::min(first_, stamp);
    last_ = steps_ == 0 ? stamp : std::max(last_, stamp);
    ++steps_;
  }
  common::Nanoseconds first() const { return first_; }
  common::Nanoseconds last() const { return last_; }

 private:
  std::size_t steps_ = 0;
  common::Nanoseconds first_ = 0;
  common::Nanoseconds last_ = 0;
};

std::vector<std::string> sensors_of_kind(const common::RecordingInfo& info, common::SensorKind kind) {
  std::vector<std::string> names;
  for (const auto& [name, sensor] : info.sensors) {
    if (sensor.kind == kind) names.push_back(name);
  }
  return names;
}

/// Whether a module takes part: asked for, or nothing was asked for and its sensor is there.
bool takes_part(const RunRequest& request, const std::string& module, bool has_sensor) {
  if (request.modules.empty()) return has_sensor;
  return std::find(request.modules.begin(), request.modules.end(), module) != request.modules.end();
}

/// The sensors somebody listens to: only their messages may count, and be rejected.
std::set<std::string> sensors_in_use(const RunRequest& request, const common::RecordingInfo& info) {
  std::set<std::string> names;
  const auto add = [&names](const std::vector<std::string>& more) { names.insert(more.begin(), more.end()); };
  add(sensors_of_kind(info, common::SensorKind::kOdometry));
  const auto lasers = sensors_of_kind(info, common::SensorKind::kLaser);
  if (!lasers.empty() && takes_part(request, "laser", true)) names.insert(lasers.front());
  const auto cameras = sensors_of_kind(info, common::SensorKind::kCamera);
  if (takes_part(request, "visual", !cameras.empty())) add(request.cameras.empty() ? cameras : request.cameras);
  return names;
}

common::ReplayOptions replay_options_of(const RunRequest& request, const common::RecordingInfo& info) {
  common::ReplayOptions options;
  options.only_sensors = sensors_in_use(request, info);
  options.from = request.from;
  options.to = request.to;
  options.arrival_delay = request.arrival_delay;
  options.stamp_offset = request.stamp_offset;
  options.sweep_duration = request.sweep_duration;
  return options;
}

/// More threads than processors only cost the modules memory.
int useful_threads(const RunRequest& request) {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, request.threads);
}

/// What was assumed of the recording stands before all that happened.
void tell_notes(const common::RecordingInfo& info, std::vector<common::Event>& events) {
  std::vector<common::Event> notes;
  for (const auto& note : info.notes) notes.push_back({info.first_stamp, "recording", "note", note});
  events.insert(events.begin(), notes.begin(), notes.end());
}

double peak_rss_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0 / 1e6;
}

}  // namespace

common::Result<RunSession> RunSession::create(const RunRequest& request) {
  auto recording = common::open_recording(request.recording, request.recording_options);
  if (!recording) return tl::unexpected(recording.error());
  const auto replay_options = replay_options_of(request, (*recording)->info());
  auto replayed = common::replay(std::move(*recording), replay_options);
  if (!replayed) return tl::unexpected(replayed.error());
  return create(request, std::move(*replayed));
}

common::Result<RunSession> RunSession::create(const RunRequest& request, std::unique_ptr<common::Recording> source) {
  RunSession session(request);
  session.recording_ = std::move(source);
  if (auto made = session.make_parts(); !made) return tl::unexpected(made.error());
  return session;
}

common::Result<void> RunSession::make_parts() {
  if (auto made = make_laser(); !made) return made;
  if (auto made = make_visual(); !made) return made;
  if (!laser() && !visual()) {
    return common::invalid_input(request_.recording.string() + ": neither a laser nor a camera, nothing to do");
  }
  if (auto restored = restore_map(); !restored) return restored;
  fusion::FusionOptions options = request_.configuration.fusion;
  if (laser() == nullptr) options.supervision.visual_only_after = 0.0;  // there is no laser to wait for
  if (free_scale().contains("visual")) options.supervision.visual_scale_drifts = true;
  auto fusion = fusion::Fusion::create(options, most_kept());
  if (!fusion) return tl::unexpected(fusion.error());
  fusion_ = std::move(*fusion);
  if (saved_alignment_) fusion_->assume(*saved_alignment_);
  return {};
}

std::unique_ptr<ExternalPoses> RunSession::external(const std::string& sensor) const {
  if (!recording().sensors.contains(sensor)) return nullptr;
  return std::make_unique<ExternalPoses>(sensor, request_.configuration.service.external_pose);
}

common::Result<void> RunSession::make_laser() {
  external_laser_ = external(kLaserPose);
  if (external_laser_) return {};
  const auto lasers = sensors_of_kind(recording(), common::SensorKind::kLaser);
  if (!takes_part(request_, "laser", !lasers.empty())) return {};
  if (lasers.empty())
    return common::invalid_input(request_.recording.string() + ": --modules laser, but no laser in it");
  if (request_.mode == RunMode::kLocalization) return make_localization(lasers.front());
  auto laser = laser_slam::LaserSlam::create(request_.configuration.laser, lasers.front(),
                                             recording().calibration.lasers.at(lasers.front()), request_.seed,
                                             useful_threads(request_), most_kept());
  if (!laser) return tl::unexpected(laser.error());
  laser_ = std::move(*laser);
  return {};
}

common::Result<void> RunSession::make_localization(const std::string& sensor) {
  auto map = read_localization_map(*request_.map);
  if (!map) return tl::unexpected(map.error());
  auto localization = laser_slam::LaserLocalization::create(request_.configuration.laser, sensor,
                                                            recording().calibration.lasers.at(sensor), *map,
                                                            request_.seed, most_kept());
  if (!localization) return tl::unexpected(localization.error());
  localization_ = std::move(*localization);
  localization_state_ = std::move(map->laser_state);
  return {};
}

common::Result<void> RunSession::check_cameras(const std::vector<std::string>& cameras) const {
  for (const auto& name : request_.cameras) {
    if (std::find(cameras.begin(), cameras.end(), name) != cameras.end()) continue;
    return common::usage_error(fmt::format("--cameras: the recording has no camera '{}', it has {}", name,
                                           cameras.empty() ? "none" : fmt::format("{}", fmt::join(cameras, ", "))));
  }
  return {};
}

common::Result<void> RunSession::make_visual() {
  external_visual_ = external(kVisualPose);
  if (external_visual_) return {};
  const auto cameras = sensors_of_kind(recording(), common::SensorKind::kCamera);
  if (auto known = check_cameras(cameras); !known) return known;
  if (!takes_part(request_, "visual", !cameras.empty())) return {};
  if (cameras.empty()) {
    return common::invalid_input(request_.recording.string() + ": --modules visual, but no camera in it");
  }
  for (const auto& name : request_.cameras.empty() ? cameras : request_.cameras) {
    cameras_.emplace(name, recording().calibration.cameras.at(name));
  }
  auto visual = visual_slam::VisualSlam::create(request_.configuration.visual, cameras_, request_.seed,
                                                useful_threads(request_), most_kept());
  if (!visual) return tl::unexpected(visual.error());
  visual_ = std::move(*visual);
  return {};
}

common::Result<void> RunSession::restore_map() {
  if (request_.map && !laser_ && !localization_ && !visual_) {
    return common::usage_error("--map: continuing or localising in a map needs the laser or the visual module");
  }
  if (!request_.map || (localization_ && (!visual_ || !is_map_bundle(*request_.map)))) return {};
  auto bundle = read_map_bundle(*request_.map);
  if (!bundle) return tl::unexpected(bundle.error());
  if (laser_) {
    if (bundle->laser_state.empty()) return common::invalid_input(request_.map->string() + ": holds no laser map");
    if (auto restored = laser_->restore(bundle->laser_state); !restored) return restored;
  }
  return visual_ ? restore_visual_map(*bundle) : common::Result<void>{};
}

/// A map without landmarks that could be recognised leaves the visual half to make one of its own.
common::Result<void> RunSession::restore_visual_map(const LoadedMapBundle& bundle) {
  const bool recognisable = std::any_of(bundle.landmarks.begin(), bundle.landmarks.end(),
                                        [](const common::Landmark& landmark) { return !landmark.views.empty(); });
  if (!recognisable || !visual_->can_search()) {
    if (laser()) return {};
    return common::invalid_input(request_.map->string() +
                                 ": holds no landmarks that the visual half could find itself by, and no laser runs");
  }
  const bool localise = request_.mode == RunMode::kLocalization;
  auto loaded =
      visual_->load(bundle.landmarks, localise ? visual_slam::MapUse::kLocalise : visual_slam::MapUse::kContinue);
  if (!loaded) return common::invalid_input(request_.map->string() + ": " + loaded.error().message);
  if (laser()) saved_alignment_ = bundle.summary.alignment;
  return {};
}

common::Result<RunSummary> RunSession::run(PipelineObserver* observer, const std::atomic<bool>& stop,
                                           PipelineRequests* requests) {
  const ServiceOptions& service = request_.configuration.service;
  RunRecorder recorder(most_kept());
  Span span;
  ObserverList observers;
  observers.add(recorder);
  observers.add(span);
  if (observer != nullptr) observers.add(*observer);

  TrajectoryFusion fusion(*fusion_);
  PipelineParts parts{recording_.get(), {}, &fusion, &observers, requests};
  if (has_laser_map()) {
    parts.modules.push_back({laser(), [this] { return grid(); }, [this] { return laser_checkpoint(); }});
  }
  if (external_laser_) parts.modules.push_back({external_laser_.get()});
  if (visual_) parts.modules.push_back({visual_.get(), nullptr, [this] { return visual_checkpoint(); }});
  if (external_visual_) parts.modules.push_back({external_visual_.get()});

  PipelineOptions options;
  options.most_kept = most_kept();
  options.threads = request_.threads;
  options.queue_capacity = static_cast<std::size_t>(service.queue_capacity);
  options.command_delay = service.command_delay;
  options.map_interval = observer != nullptr ? common::from_seconds(service.map_interval) : 0;
  options.rate = request_.rate;
  if (request_.live) {
    options.live_backlog = service.live_backlog;
    options.checkpoint_interval = common::from_seconds(service.save_interval);
  }

  const auto start = std::chrono::steady_clock::now();
  const auto outcome = run_pipeline(parts, options, stop);
  if (!outcome) return tl::unexpected(outcome.error());

  RunSummary summary;
  summary.seed = request_.seed;
  summary.recording = request_.recording.string();
  summary.incomplete = outcome->interrupted;
  summary.counters = outcome->counters;
  summary.log = recorder.log();
  tell_notes(recording(), summary.log.events);
  summary.first_stamp = span.first();
  summary.last_stamp = span.last();
  summary.duration_s = common::to_seconds(span.last() - span.first());
  gather(summary);
  summary.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  summary.peak_rss_mb = peak_rss_mb();
  if (auto judged = judge(request_, free_scale(), summary); !judged) return tl::unexpected(judged.error());
  return summary;
}

std::size_t RunSession::most_kept() const {
  return request_.live ? static_cast<std::size_t>(request_.configuration.service.live_history) : common::kKeepAll;
}

std::set<PoseSource> RunSession::map_makers() const {
  std::set<PoseSource> makers;
  if (has_laser_map()) makers.insert(PoseSource::kLaser);
  if (visual_) makers.insert(PoseSource::kVisual);
  return makers;
}

common::SlamModule* RunSession::laser() const {
  if (external_laser_) return external_laser_.get();
  return localization_ ? static_cast<common::SlamModule*>(localization_.get()) : laser_.get();
}

common::SlamModule* RunSession::visual() const {
  return external_visual_ ? static_cast<common::SlamModule*>(external_visual_.get()) : visual_.get();
}

common::OccupancyGrid RunSession::grid() const { return localization_ ? localization_->grid() : laser_->grid(); }

std::set<std::string> RunSession::free_scale() const {
  if (external_visual_) return {"visual", "visual_final"};
  if (!visual_ || request_.configuration.visual.motion.model == visual_slam::MotionModelKind::kOdometry) return {};
  if (laser()) return {"visual", "visual_final"};
  return {"visual", "visual_final", "fused", "fused_final"};
}

ModuleCheckpoint RunSession::laser_checkpoint() const {
  return {.grid = grid(),
          .laser_state = laser_ ? laser_->serialize().value_or(std::string()) : localization_state_,
          .path = laser()->final_trajectory()};
}

ModuleCheckpoint RunSession::visual_checkpoint() const {
  return {.landmarks = visual_->landmarks(),
          .keyframes = visual_->keyframes(),
          .cameras = cameras_,
          .path = visual_->final_trajectory()};
}

void RunSession::gather(RunSummary& summary) const {
  if (laser_) laser_->refine();
  const auto laser_final = laser() ? laser()->final_trajectory() : common::Trajectory2{};
  const auto visual_final = visual() ? visual()->final_trajectory() : common::Trajectory2{};
  const auto fused = fusion_->finish(laser_final, visual_final);
  if (laser() && visual()) summary.alignment = fused.alignment;
  summary.log.events.insert(summary.log.events.end(), fused.events.begin(), fused.events.end());

  for (const auto source : {PoseSource::kOdometry, PoseSource::kLaser, PoseSource::kVisual, PoseSource::kFused}) {
    const auto found = summary.log.trajectories.find(source);
    const bool tracked = found != summary.log.trajectories.end();
    if (!tracked && !summary.counters.contains(source)) continue;
    summary.trajectories.push_back({common::to_string(source), tracked ? found->second : common::Trajectory2{}});
  }
  if (laser()) summary.trajectories.push_back({"laser_final", laser_final});
  if (visual()) summary.trajectories.push_back({"visual_final", visual_final});
  summary.trajectories.push_back({"fused_final", fused.fused_final});

  if (has_laser_map()) {
    summary.grid = grid();
    summary.laser_state = laser_ ? laser_->serialize().value_or(std::string()) : localization_state_;
  }
  if (visual_) {
    summary.landmarks = visual_->landmarks();
    summary.keyframes = visual_->keyframes();
    summary.cameras = cameras_;
    summary.sample_images = visual_->sample_images();
  }
}

}  // namespace slamfuse::service
