// SPDX-License-Identifier: BSD-3-Clause
#include "service/serve_command.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "service/dds_publisher.hpp"
#include "service/diagnostics_publisher.hpp"
#include "service/map_saver.hpp"
#include "service/output_folder.hpp"
#include "service/run_conclusion.hpp"
#include "service/run_files.hpp"
#include "service/run_session.hpp"

namespace slamfuse::service {
namespace {

using common::Result;
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

/// Whether a module may take part.
bool wants(const RunRequest& run, const std::string& module) {
  return run.modules.empty() || std::ranges::find(run.modules, module) != run.modules.end();
}

/// From one set of modules to their results in the output folder.
class Session {
 public:
  Session(const RunRequest& request, const Tell& tell) : request_(request), tell_(tell) {}

  Result<std::string> run(LiveSource& source) {
    auto session = RunSession::create(request_, std::make_unique<BorrowedSource>(source));
    if (!session) return tl::unexpected(session.error());
    const auto folder = OutputFolder::create(request_.out, ResultKind::kRun);
    if (!folder) return tl::unexpected(folder.error());
    DdsOptions dds = request_.configuration.service.dds;
    dds.reader_wait = 0.0;  // a service does not wait for its listeners
    const auto publisher = DdsPublisher::create(dds, [&session] { return session->alignment(); });
    if (!publisher) return tl::unexpected(publisher.error());

    auto summary = run(*session, **publisher, (*folder)->path());
    if (!summary) return tl::unexpected(summary.error());
    tell_failures(**publisher, *summary);
    auto done = write_run_files(*summary, **folder);
    if (done) done = (*folder)->publish();
    if (!done) return tl::unexpected(done.error());
    (*publisher)->finish(final_state_of(*summary));
    if (!has_pose(*summary)) return common::failed("no module could make a pose of what was heard");
    can_continue_ = !summary->laser_state.empty();
    return in_words(*summary, (*folder)->path());
  }

  /// Whether its map can be gone on with.
  bool can_continue() const { return can_continue_; }

 private:
  Result<RunSummary> run(RunSession& session, DdsPublisher& publisher, const std::filesystem::path& folder) {
    MapSaver saver(folder / "map", request_.seed, request_.recording.string(),
                   [&session] { return session.alignment(); });
    EventTeller events(tell_);
    ObserverList observers;
    observers.add(publisher);
    observers.add(saver);
    observers.add(events);
    static const std::atomic<bool> kToTheEnd{false};  // of the source: what has arrived is still worth processing
    auto summary = session.run(&observers, kToTheEnd);
    if (const auto failure = saver.failure()) tell_("the map could not be saved: " + failure->message);
    return summary;
  }

  const RunRequest& request_;
  const Tell& tell_;
  bool can_continue_ = false;
};

}  // namespace

Result<std::string> run_serve(const ServeRequest& request, const Tell& tell, const std::atomic<bool>& stop,
                              const std::function<void()>& on_started) {
  // What must not be found out only when a robot has driven for an hour.
  if (const auto folder = OutputFolder::create(request.run.out, ResultKind::kRun); !folder) {
    return tl::unexpected(folder.error());
  }
  on_started();
  LiveSourceOptions options = request.source;
  options.lasers = wants(request.run, "laser");
  options.cameras = wants(request.run, "visual");
  auto source = LiveSource::create(options, stop);
  if (!source) return tl::unexpected(source.error());
  const auto diagnostics = DiagnosticsPublisher::start(**source, tell);
  if (!diagnostics) return tl::unexpected(diagnostics.error());
  tell("listening");
  if (auto prepared = (*source)->prepare(tell); !prepared) return tl::unexpected(prepared.error());
  for (const auto& note : (*source)->info().notes) tell(note);
  tell("starting with " + sensors_in_words((*source)->info()));

  RunRequest run = request.run;
  run.recording = (*source)->info().path;
  run.live = true;
  while (true) {
    Session session(run, tell);
    auto outcome = session.run(**source);
    const auto restart = (*source)->restart_wanted();
    if (!outcome || !restart || stop) return outcome;
    tell(*restart + "; starting anew" + (session.can_continue() ? " in the map made so far" : ""));
    if (session.can_continue() && run.mode == RunMode::kSlam) run.map = run.out / "map";
  }
}

}  // namespace slamfuse::service
