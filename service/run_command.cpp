// SPDX-License-Identifier: BSD-3-Clause
#include "service/run_command.hpp"

#include <filesystem>
#include <memory>
#include <system_error>

#include "service/dds_publisher.hpp"
#include "service/output_folder.hpp"
#include "service/run_conclusion.hpp"
#include "service/run_files.hpp"
#include "service/run_session.hpp"

namespace slamfuse::service {
namespace {

/// The publisher `--dds` asks for; none otherwise.
common::Result<std::unique_ptr<DdsPublisher>> make_publisher(const RunRequest& request, const RunSession& session) {
  if (!request.dds) return std::unique_ptr<DdsPublisher>();
  const DdsOptions& options = request.configuration.service.dds;
  const auto participant = idl::Participant::join(options.network);
  if (!participant) return tl::unexpected(participant.error());
  return DdsPublisher::create(*participant, options, [&session] { return session.alignment(); });
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

  const auto publisher = make_publisher(request, *session);
  if (!publisher) return tl::unexpected(publisher.error());

  ObserverList observers;
  if (*publisher) observers.add(**publisher);
  if (progress != nullptr) observers.add(*progress);
  auto summary = session->run(&observers, stop);
  if (!summary) return tl::unexpected(summary.error());
  if (*publisher) tell_failures(**publisher, *summary);

  auto done = write_run_files(*summary, **folder);
  if (done) done = (*folder)->publish();
  if (!done) return tl::unexpected(done.error());
  if (summary->incomplete) {
    return tl::unexpected(common::Error{common::ErrorKind::kInterrupted,
                                        "interrupted; what was computed so far is in " + (*folder)->path().string()});
  }
  if (*publisher) (*publisher)->finish(final_state_of(*summary));
  if (!has_pose(*summary)) {
    return common::failed("no module could make a pose of this recording; see the events in " +
                          ((*folder)->path() / "metrics.json").string());
  }
  return in_words(*summary, (*folder)->path());
}

}  // namespace slamfuse::service
