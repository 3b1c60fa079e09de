// SPDX-License-Identifier: BSD-3-Clause
#include "service/serve_command.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "service/dds_outputs.hpp"
#include "service/dds_publisher.hpp"
#include "service/diagnostics_publisher.hpp"
#include "service/map_saver.hpp"
#include "service/output_folder.hpp"
#include "service/run_conclusion.hpp"
#include "service/run_files.hpp"
#include "service/run_session.hpp"
#include "service/serve_control.hpp"

namespace slamfuse::service {
namespace {

using common::Result;
/// In ROS 2's graph.
const char* const kNodeName = "slamfuse";

using Tell = std::function<void(const std::string&)>;

/// The live source as one session's recording: the source outlives the session.
class BorrowedSource final : public common::Recording {
 public:
  explicit BorrowedSource(LiveSource& source) : source_(source) {}
  const common::RecordingInfo& info() const override { return source_.info(); }
  Result<std::optional<common::RecordingItem>> next() override { return source_.next(); }

 private:
  LiveSource& source_;
};

/// Hands events on to the log.
class EventTeller : public PipelineObserver {
 public:
  explicit EventTeller(const Tell& tell) : tell_(tell) {}
  void on_event(const common::Event& event) override {
    tell_(fmt::format("{} {}: {}: {}", common::format_seconds(event.stamp), event.module, event.kind, event.detail));
  }
  void on_corrected_pose(const fusion::CorrectedPose& /*pose*/) override {
    if (!std::exchange(first_, false)) return;
    tell_("the first pose is out");
  }

 private:
  const Tell& tell_;
  bool first_ = true;
};

std::string sensors_in_words(const common::RecordingInfo& info) {
  std::vector<std::string> names;
  for (const auto& [name, sensor] : info.sensors) names.push_back(name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Keeps the books of what was dropped where the robot's topics are watched.
class DropTeller : public PipelineObserver {
 public:
  explicit DropTeller(LiveSource& source) : source_(source) {}
  void on_dropped(const std::string& sensor) override { source_.dropped(sensor); }

 private:
  LiveSource& source_;
};

/// Whether a module may take part.
bool wants(const RunRequest& run, const std::string& module) {
  return run.modules.empty() || std::ranges::find(run.modules, module) != run.modules.end();
}

/// From one set of modules to their results in the output folder.
class Session {
 public:
  /// `on_written` hears that the results are in the output folder, before they are told over DDS.
  Session(std::shared_ptr<DdsOutputs> outputs, ServeControl& control, const RunRequest& request, const Tell& tell,
          OnSaved on_written)
      : outputs_(std::move(outputs)),
        control_(control),
        request_(request),
        tell_(tell),
        on_written_(std::move(on_written)) {}

  Result<std::string> run(LiveSource& source) {
    auto session = RunSession::create(request_, std::make_unique<BorrowedSource>(source));
    if (!session) return tl::unexpected(session.error());
    const auto folder = OutputFolder::create(request_.out, ResultKind::kRun);
    if (!folder) return tl::unexpected(folder.error());
    DdsPublisher publisher(outputs_, request_.configuration.service.dds, [&session] { return session->alignment(); });

    started_ = true;
    auto summary = run(*session, source, publisher, (*folder)->path());
    if (!summary) return tl::unexpected(summary.error());
    tell_failures(publisher, *summary);
    auto done = write_run_files(*summary, **folder);
    if (done) done = (*folder)->publish();
    if (!done) return tl::unexpected(done.error());
    has_pose_ = service::has_pose(*summary);
    can_continue_ = !summary->laser_state.empty();
    const std::string outcome = in_words(*summary, (*folder)->path());
    on_written_(outcome);
    publisher.finish(final_state_of(*summary));
    return outcome;
  }

  /// Whether its modules could be made.
  bool started() const { return started_; }
  /// Whether it ever knew where the robot was.
  bool has_pose() const { return has_pose_; }
  /// Whether its map can be gone on with.
  bool can_continue() const { return can_continue_; }

 private:
  Result<RunSummary> run(RunSession& session, LiveSource& source, DdsPublisher& publisher,
                         const std::filesystem::path& folder) {
    const ServiceOptions& service = request_.configuration.service;
    const auto saver = std::make_shared<MapSaver>(
        folder / "map", request_.seed, request_.recording.string(), [&session] { return session.alignment(); },
        static_cast<std::size_t>(service.live_history));
    const auto requests = std::make_shared<PipelineRequests>();
    EventTeller events(tell_);
    DropTeller drops(source);
    ObserverList observers;
    observers.add(publisher);
    observers.add(*saver);
    observers.add(events);
    observers.add(drops);
    static const std::atomic<bool> kToTheEnd{false};  // of the source: what has arrived is still worth processing
    control_.begin({requests, saver, session.map_makers(), {request_.mode, request_.map}});
    auto summary = session.run(&observers, kToTheEnd, requests.get());
    control_.end();
    if (const auto failure = saver->failure()) tell_("the map could not be saved: " + failure->message);
    return summary;
  }

  std::shared_ptr<DdsOutputs> outputs_;
  ServeControl& control_;
  const RunRequest& request_;
  const Tell& tell_;
  OnSaved on_written_;
  bool started_ = false;
  bool has_pose_ = false;
  bool can_continue_ = false;
};

/// Nobody waits for an answer of a service that has ended, however it ended.
class ClosedAtEnd {
 public:
  explicit ClosedAtEnd(ServeControl& control) : control_(control) {}
  ClosedAtEnd(const ClosedAtEnd&) = delete;
  ClosedAtEnd& operator=(const ClosedAtEnd&) = delete;
  ~ClosedAtEnd() { control_.close(); }

 private:
  ServeControl& control_;
};

/// One session after the other, until one fails or `stop` is set.
Result<std::string> run_sessions(const std::shared_ptr<DdsOutputs>& outputs, LiveSource& source, ServeControl& control,
                                 RunRequest run, const Tell& tell, const std::atomic<bool>& stop,
                                 const OnSaved& on_saved) {
  SessionSetup before{run.mode, run.map};
  bool has_pose = false;  // of any session
  std::set<std::string> told_notes;
  while (true) {
    for (const std::string& note : source.info().notes) {
      if (told_notes.insert(note).second) tell(note);
    }
    Session session(outputs, control, run, tell, [&](const Result<std::string>& outcome) {
      if (stop) on_saved(outcome);
    });
    auto outcome = session.run(source);
    if (!outcome && !session.started() && control.wanted()) {
      tell("going on as before: " + outcome.error().message);
      control.refuse(outcome.error());
      std::tie(run.mode, run.map) = std::tie(before.mode, before.map);
      continue;
    }
    const auto restart = source.restart_wanted();
    if (!outcome) return outcome;
    has_pose |= session.has_pose();
    if (!restart || stop) {
      if (!has_pose) return common::failed("no module could make a pose of what was heard");
      return outcome;
    }
    if (session.can_continue() && run.mode == RunMode::kSlam) run.map = run.out / "map";
    before = {run.mode, run.map};
    if (const auto wanted = control.wanted()) {
      tell(*restart);
      std::tie(run.mode, run.map) = std::tie(wanted->mode, wanted->map);
    } else {
      tell(fmt::format("{}; starting anew{} with {}", *restart, session.can_continue() ? " in the map made so far" : "",
                       sensors_in_words(source.info())));
    }
  }
}

}  // namespace

Result<std::string> run_serve(const ServeRequest& request, const Tell& tell, const std::atomic<bool>& stop,
                              const std::function<void()>& on_started, const OnSaved& on_saved) {
  // What must not be found out only when a robot has driven for an hour.
  if (const auto folder = OutputFolder::create(request.run.out, ResultKind::kRun); !folder) {
    return tl::unexpected(folder.error());
  }
  const auto names = namespace_of(request.run.configuration.service.dds);
  if (!names) return tl::unexpected(names.error());
  on_started();
  LiveSourceOptions options = request.source;
  options.odometry = request.run.configuration.service.odometry;
  options.inbox.lasers = wants(request.run, "laser");
  options.inbox.cameras = wants(request.run, "visual");
  options.needs_laser = options.inbox.lasers && !request.run.modules.empty();
  options.needs_camera = options.inbox.cameras && !request.run.modules.empty();
  const DdsOptions& dds = request.run.configuration.service.dds;
  const auto participant = idl::Participant::join(dds.network);
  if (!participant) return tl::unexpected(participant.error());
  auto source = LiveSource::create(*participant, options, stop);
  if (!source) return tl::unexpected(source.error());
  auto presence = idl::GraphPresence::create(*participant, {*names, kNodeName}, dds.ros_graph);
  if (!presence) return tl::unexpected(presence.error());
  const auto outputs = DdsOutputs::create(*participant, *names, dds.publish_tf);
  if (!outputs) return tl::unexpected(outputs.error());
  const ExternalPoseOptions& external = request.run.configuration.service.external_pose;
  auto told = (*outputs)->add_initial_pose(*participant, common::PoseSource::kLaser, external.laser_initialpose);
  if (told) {
    told = (*outputs)->add_initial_pose(*participant, common::PoseSource::kVisual, external.visual_initialpose);
  }
  if (!told) return tl::unexpected(told.error());
  const auto diagnostics =
      DiagnosticsPublisher::start(*participant, *std::move(presence), names->resolve(kNodeName), **source, tell);
  if (!diagnostics) return tl::unexpected(diagnostics.error());
  ServeControl control(**source, request.run.out / "map");
  const auto services = OperatorServices::start(*participant, *names, control, tell);
  if (!services) return tl::unexpected(services.error());
  tell(dds.network == idl::Network::kAll ? "listening"
                                         : "listening to this machine (service.dds.network: all opens up)");
  if (auto prepared = (*source)->prepare(tell); !prepared) {
    on_saved(tl::unexpected(prepared.error()));
    return tl::unexpected(prepared.error());
  }
  tell("starting with " + sensors_in_words((*source)->info()));

  RunRequest run = request.run;
  run.recording = (*source)->info().path;
  run.live = true;
  const ClosedAtEnd closed(control);
  auto outcome = run_sessions(*outputs, **source, control, run, tell, stop, on_saved);
  on_saved(outcome);
  (*outputs)->wait_for_acknowledgments(dds.linger);
  return outcome;
}

}  // namespace slamfuse::service
