// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "common/pose_estimate.hpp"
#include "service/live_source.hpp"
#include "service/map_saver.hpp"
#include "service/operator_services.hpp"
#include "service/pipeline_requests.hpp"
#include "service/run_request.hpp"

namespace slamfuse::service {

/// What a set of modules works with, and so what an operator may change from one set to the next.
struct SessionSetup {
  RunMode mode = RunMode::kSlam;
  std::optional<std::filesystem::path> map;  ///< as RunRequest::map
};

/// What an operator can reach of the session that runs.
struct RunningSession {
  std::shared_ptr<PipelineRequests> requests;
  std::shared_ptr<MapSaver> saver;
  std::set<common::PoseSource> map_makers;  ///< halves of ours that run
  SessionSetup setup;
};

/// Carries out what an operator asks of `serve`: within the running session, or by ending it for one with another
/// setup. A setup that cannot be used is refused before anything ends.
class ServeControl : public OperatorActions {
 public:
  /// `own_map` is where sessions save their map; `source` must outlive this.
  ServeControl(LiveSource& source, std::filesystem::path own_map) : source_(source), own_map_(std::move(own_map)) {}

  Answer save_map() override;
  Answer load_map(const std::string& path) override;
  Answer set_mode(const std::string& mode) override;
  Answer align_now() override;
  Answer relocalise() override;
  Answer set_pose(const common::SetPose& pose) override;

  /// The thread of `serve`: a session has started, with the setup that was asked for if one was.
  void begin(RunningSession session);
  /// It has ended.
  void end();
  /// The setup an operator wants next; stays until begin() or refuse().
  std::optional<SessionSetup> wanted() const;
  /// The wanted setup could not be started.
  void refuse(const common::Error& error);
  /// Nothing will start any more.
  void close();

 private:
  std::optional<RunningSession> running() const;
  Answer ask(const PipelineRequest& request);
  Answer change_to(SessionSetup setup, const std::string& reason);

  LiveSource& source_;
  const std::filesystem::path own_map_;
  mutable std::mutex mutex_;
  std::condition_variable answered_;
  std::optional<RunningSession> running_;
  std::optional<SessionSetup> wanted_;
  std::optional<Answer> answer_;
};

}  // namespace slamfuse::service
