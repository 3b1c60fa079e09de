// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_command.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "service/dds_publisher.hpp"
#include "service/output_folder.hpp"
#include "service/run_conclusion.hpp"
#include "service/run_files.hpp"
#include "service/run_session.hpp"

namespace slamfuse::service {
namespace {

/// What `--dds` asks for; nothing otherwise. Waits for listeners as the options say.
common::Result<std::shared_ptr<DdsOutputs>> make_outputs(const RunRequest& request) {
  if (!request.dds) return std::shared_ptr<DdsOutputs>();
  const DdsOptions& options = request.configuration.service.dds;
  const auto names = namespace_of(options);
  if (!names) return tl::unexpected(names.error());
  const auto participant = idl::Participant::join(options.network);
  if (!participant) return tl::unexpected(participant.error());
  auto outputs = DdsOutputs::create(*participant, *names, options.publish_tf);
  if (outputs) (*outputs)->wait_for_listeners(options.reader_wait);
  return outputs;
}

}  // namespace

common::Result<std::string> run_recording(const RunRequest& request, PipelineObserver* progress,
                                          const std::atomic<bool>& stop, const std::function<void()>& on_started) {
  auto session = RunSession::create(request);
  if (!session) return tl::unexpected(session.error());
  std::error_code error;
  if (std::filesystem::equivalent(request.out, request.recording, error)) {
    return common::invalid_input(request.out.string() + ": the output folder must not be the recording itself");
  }
  on_started();
  const auto folder = OutputFolder::create(request.out, ResultKind::kRun);
  if (!folder) return tl::unexpected(folder.error());

  const auto outputs = make_outputs(request);
  if (!outputs) return tl::unexpected(outputs.error());
  std::optional<DdsPublisher> publisher;
  if (*outputs) {
    publisher.emplace(*outputs, request.configuration.service.dds, [&session] { return session->alignment(); });
  }

  ObserverList observers;
  if (publisher) observers.add(*publisher);
  if (progress != nullptr) observers.add(*progress);
  auto summary = session->run(&observers, stop);
  if (!summary) return tl::unexpected(summary.error());
  if (publisher) tell_failures(*publisher, *summary);

  auto done = write_run_files(*summary, **folder);
  if (done) done = (*folder)->publish();
  if (!done) return tl::unexpected(done.error());
  if (summary->incomplete) {
    return tl::unexpected(common::Error{common::ErrorKind::kInterrupted,
                                        "interrupted; what was computed so far is in " + (*folder)->path().string()});
  }
  if (publisher) {
    publisher->finish(final_state_of(*summary));
    (*outputs)->wait_for_acknowledgments(request.configuration.service.dds.linger);
  }
  if (!has_pose(*summary)) {
    return common::failed("no module could make a pose of this recording; see the events in " +
                          ((*folder)->path() / "metrics.json").string());
  }
  return in_words(*summary, (*folder)->path());
}

}  // namespace slamfuse::service
