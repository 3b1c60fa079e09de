// SPDX-License-Identifier: BSD-3-Clause
#include "service/serve_control.hpp"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "service/map_bundle.hpp"
#include "service/map_source.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::PoseSource;

/// For the next message of the robot to be processed.
constexpr auto kPatience = 5s;
/// For the next pose of each half, and the map to be written.
constexpr auto kSavePatience = 20s;
/// For a session to end with all its results and another to start.
constexpr auto kChangePatience = 120s;

const char* const kNotRunning = "nothing runs yet: no sensor was heard, or the modules are just being exchanged";

std::string in_words(RunMode mode) { return mode == RunMode::kSlam ? "slam" : "localization"; }

/// Whether modules can work with that.
common::Result<void> check(const SessionSetup& setup) {
  if (setup.mode == RunMode::kLocalization) return read_localization_map(*setup.map).map([](const auto&) {});
  if (!setup.map) return {};
  const auto bundle = read_map_bundle(*setup.map);
  if (!bundle) return tl::unexpected(bundle.error());
  if (bundle->laser_state.empty()) {
    return common::invalid_input(setup.map->string() + ": holds no laser map to continue in");
  }
  return {};
}

}  // namespace

OperatorActions::Answer ServeControl::save_map() {
  const auto session = running();
  if (!session) return common::failed(kNotRunning);
  if (session->map_makers.empty()) return common::failed("no half of ours makes a map");
  const auto saved = session->saver->save_new(
      session->map_makers, [&] { session->requests->want_checkpoints(); }, kSavePatience);
  if (!saved) return tl::unexpected(saved.error());
  return "the map is in " + own_map_.string();
}

OperatorActions::Answer ServeControl::load_map(const std::string& path) {
  const auto session = running();
  if (!session) return common::failed(kNotRunning);
  if (!session->map_makers.contains(PoseSource::kLaser)) return common::failed("no laser half runs to use a map");
  SessionSetup setup{session->setup.mode, path};
  if (auto usable = check(setup); !usable) return tl::unexpected(usable.error());
  return change_to(std::move(setup), path + " is loaded");
}

OperatorActions::Answer ServeControl::set_mode(const std::string& mode) {
  if (mode != "slam" && mode != "localization") {
    return common::usage_error(fmt::format("mode '{}' (allowed: slam, localization)", mode));
  }
  const auto session = running();
  if (!session) return common::failed(kNotRunning);
  if (!session->map_makers.contains(PoseSource::kLaser)) return common::failed("no laser half runs to localise");
  SessionSetup setup = session->setup;
  if (in_words(setup.mode) == mode) return "the mode is " + mode + " already";
  setup.mode = mode == "slam" ? RunMode::kSlam : RunMode::kLocalization;
  if (setup.mode == RunMode::kLocalization) {
    setup.map = own_map_;  // as this session leaves it
    if (auto saved = save_map(); !saved) return saved;
  }
  if (auto usable = check(setup); !usable) return tl::unexpected(usable.error());
  return change_to(std::move(setup), "the mode becomes " + mode);
}

OperatorActions::Answer ServeControl::align_now() { return ask(AlignNow{}); }

OperatorActions::Answer ServeControl::relocalise() {
  const auto session = running();
  if (session && session->setup.mode != RunMode::kLocalization) {
    return common::failed("mode slam makes a map and does not search in one; first set_mode localization");
  }
  return ask(SearchMap{});
}

OperatorActions::Answer ServeControl::set_pose(const common::SetPose& pose) {
  const auto session = running();
  if (session && !session->map_makers.contains(PoseSource::kLaser)) {
    return common::failed("no laser half of ours runs that could be told a pose");
  }
  return ask(PlaceRobot{pose});
}

void ServeControl::begin(RunningSession session) {
  const std::lock_guard lock(mutex_);
  running_ = std::move(session);
  if (!wanted_) return;
  answer_ = fmt::format("running in mode {}{}", in_words(wanted_->mode),
                        wanted_->map ? " with " + wanted_->map->string() : std::string());
  wanted_.reset();
  answered_.notify_all();
}

void ServeControl::end() {
  const std::lock_guard lock(mutex_);
  running_.reset();
}

std::optional<SessionSetup> ServeControl::wanted() const {
  const std::lock_guard lock(mutex_);
  return wanted_;
}

void ServeControl::refuse(const common::Error& error) {
  const std::lock_guard lock(mutex_);
  wanted_.reset();
  answer_ = tl::unexpected(error);
  answered_.notify_all();
}

void ServeControl::close() { refuse({common::ErrorKind::kInterrupted, "the service stops"}); }

std::optional<RunningSession> ServeControl::running() const {
  const std::lock_guard lock(mutex_);
  return running_;
}

OperatorActions::Answer ServeControl::ask(const PipelineRequest& request) {
  const auto session = running();
  if (!session) return common::failed(kNotRunning);
  return session->requests->ask(request, kPatience);
}

OperatorActions::Answer ServeControl::change_to(SessionSetup setup, const std::string& reason) {
  std::unique_lock lock(mutex_);
  if (!running_) return common::failed(kNotRunning);
  wanted_ = std::move(setup);
  answer_.reset();
  source_.end_session(reason);
  if (!answered_.wait_for(lock, kChangePatience, [this] { return answer_.has_value(); })) {
    return common::failed("the modules are still being exchanged");
  }
  return *answer_;
}

}  // namespace slamfuse::service
