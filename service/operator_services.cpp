// SPDX-License-Identifier: BSD-3-Clause
#include "service/operator_services.hpp"

#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "idl/reader.hpp"
#include "idl/service_server.hpp"
#include "idl/waitset.hpp"
#include "service/ros_frames.hpp"
#include "service/ros_to_sensor.hpp"

namespace slamfuse::service {
namespace {

/// How long the end of the service may go unnoticed.
constexpr std::chrono::milliseconds kNap{100};

using Answer = OperatorActions::Answer;

/// One service with what it does.
template <class Service>
struct Offer {
  std::string name;
  idl::ServiceServer<Service> server;
  std::function<Answer(const typename Service::Request&)> action;

  /// Answers all requests that are there.
  void serve(const std::function<void(const std::string&)>& tell) {
    for (auto request = server.take(); request && *request; request = server.take()) {
      const Answer answer = action(***request);
      idl::Message<typename Service::Response> response;
      response->success = answer.has_value();
      const std::string text = answer ? *answer : answer.error().message;
      idl::assign(response->message, text);
      tell(fmt::format("{}: {}", name, text));
      if (const auto sent = server.answer(**request, response); !sent) tell(name + ": " + sent.error().message);
    }
  }
};

/// Everything offered.
struct Desk {
  std::vector<Offer<idl::Trigger>> triggers;
  Offer<idl::SetMode> set_mode;
  Offer<idl::LoadMap> load_map;
  idl::Reader<idl::PoseWithCovarianceStamped> initial_pose;
  idl::WaitSet waitset;
  OperatorActions& actions;
  std::function<void(const std::string&)> tell;

  common::Result<void> wait_for_all() {
    for (const auto& offer : triggers) {
      if (auto added = waitset.add(offer.server.reader()); !added) return added;
    }
    if (auto added = waitset.add(set_mode.server.reader()); !added) return added;
    if (auto added = waitset.add(load_map.server.reader()); !added) return added;
    return waitset.add(initial_pose.untyped());
  }

  void run(const std::stop_token& done) {
    while (!done.stop_requested()) {
      if (!waitset.wait(kNap)) continue;
      for (auto& offer : triggers) offer.serve(tell);
      set_mode.serve(tell);
      load_map.serve(tell);
      for (auto message = initial_pose.take(); message && *message; message = initial_pose.take()) {
        const Answer answer =
            set_pose_of(***message).and_then([&](const common::SetPose& pose) { return actions.set_pose(pose); });
        tell("initialpose: " + (answer ? *answer : answer.error().message));
      }
    }
  }
};

template <class Service, class Action>
common::Result<Offer<Service>> offer(const idl::Participant& participant, const std::string& name, Action action) {
  return idl::ServiceServer<Service>::create(participant, name).map([&](idl::ServiceServer<Service>&& server) {
    return Offer<Service>{name, std::move(server), std::move(action)};
  });
}

}  // namespace

common::Result<std::unique_ptr<OperatorServices>> OperatorServices::start(
    const idl::Participant& participant, const idl::RosNamespace& names, OperatorActions& actions,
    const std::function<void(const std::string&)>& tell) {
  auto set_mode = offer<idl::SetMode>(
      participant, names.resolve("slamfuse/set_mode"),
      [&](const idl::SetMode::Request& request) { return actions.set_mode(idl::text_of(request.mode)); });
  if (!set_mode) return tl::unexpected(set_mode.error());
  auto load_map = offer<idl::LoadMap>(
      participant, names.resolve("slamfuse/load_map"),
      [&](const idl::LoadMap::Request& request) { return actions.load_map(idl::text_of(request.path)); });
  if (!load_map) return tl::unexpected(load_map.error());
  auto initial_pose = idl::Reader<idl::PoseWithCovarianceStamped>::create(participant, names.resolve("initialpose"),
                                                                          idl::QosProfile::kCommandInput);
  if (!initial_pose) return tl::unexpected(initial_pose.error());
  auto waitset = idl::WaitSet::create(participant);
  if (!waitset) return tl::unexpected(waitset.error());
  auto desk = std::make_unique<Desk>(Desk{
      {}, *std::move(set_mode), *std::move(load_map), *std::move(initial_pose), *std::move(waitset), actions, tell});
  const std::pair<const char*, Answer (OperatorActions::*)()> triggers[] = {
      {"slamfuse/save_map", &OperatorActions::save_map},
      {"slamfuse/align_now", &OperatorActions::align_now},
      {"slamfuse/reinitialize_global_localization", &OperatorActions::relocalise}};
  for (const auto& [name, action] : triggers) {
    auto made =
        offer<idl::Trigger>(participant, names.resolve(name),
                            [&actions, action = action](const idl::Trigger::Request&) { return (actions.*action)(); });
    if (!made) return tl::unexpected(made.error());
    desk->triggers.push_back(*std::move(made));
  }
  if (auto waiting = desk->wait_for_all(); !waiting) return tl::unexpected(waiting.error());
  std::unique_ptr<OperatorServices> services(new OperatorServices);
  services->thread_ = std::jthread([desk = std::move(desk)](const std::stop_token& done) { desk->run(done); });
  return services;
}

common::Result<common::SetPose> set_pose_of(const idl::PoseWithCovarianceStamped& message) {
  const auto read = from_ros(message);
  if (!read) return tl::unexpected(read.error());
  if (read->header.frame != kMapFrame) {
    return common::invalid_input(fmt::format("a pose in frame '{}' (allowed: {})", read->header.frame, kMapFrame));
  }
  return common::SetPose{common::to_pose2(read->pose), *read->covariance};
}

}  // namespace slamfuse::service
