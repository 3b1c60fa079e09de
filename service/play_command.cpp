// SPDX-License-Identifier: BSD-3-Clause
#include "service/play_command.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>
#include <thread>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "common/replay.hpp"
#include "idl/participant.hpp"
#include "service/clock_now.hpp"
#include "service/pacer.hpp"
#include "service/recording_publisher.hpp"
#include "service/sensor_topic.hpp"

namespace slamfuse::service {
namespace {

/// A reader found us, but may not take our messages for another moment: best-effort ones would miss the first.
constexpr std::chrono::milliseconds kSettle{500};
/// At the end, for reliable readers to get what is under way [s].
constexpr double kLinger = 2.0;

common::Result<std::unique_ptr<common::Recording>> open(const PlayRequest& request) {
  auto recording = common::open_recording(request.recording, request.recording_options);
  if (!recording) return recording;
  common::ReplayOptions options;
  options.from = request.from;
  options.to = request.to;
  return common::replay(std::move(*recording), options);
}

/// What was sent, and what was not.
struct Tally {
  std::map<std::string, std::size_t> sent;  // by sensor
  std::size_t rejected = 0;
  std::string first_rejected;

  void add(const common::RejectedMessage& message) {
    if (rejected++ == 0) first_rejected = message.reason;
  }
};

std::string in_words(const PlayRequest& request, const Tally& tally, const common::RecordingInfo& info,
                     const RecordingPublisher& publisher) {
  std::string text = fmt::format("played {}\n", request.recording.string());
  for (const auto& [sensor, count] : tally.sent) {
    text += fmt::format("  {:<18} {} messages\n", topic_of(sensor, info.sensors.at(sensor).kind), count);
  }
  if (tally.rejected > 0) {
    text += fmt::format("  {} messages could not be used, the first: {}\n", tally.rejected, tally.first_rejected);
  }
  if (const UnsentMessages& unsent = publisher.unsent(); unsent.count > 0) {
    text += fmt::format("  {} messages could not be sent, the first: {}\n", unsent.count, unsent.first->message);
  }
  return text;
}

/// Between the last stamp of a turn and the first of the next.
constexpr common::Nanoseconds kBetweenTurns = common::kNanosecondsPerSecond;

}  // namespace

common::SensorMessage Continuation::next(common::SensorMessage message) {
  const common::Nanoseconds recorded = common::stamp_of(message);
  if (!first_) {
    first_ = recorded;
    if (later_turn_) shift_ = newest_ + kBetweenTurns - recorded;
  }
  std::visit([this](auto& m) { m.stamp += shift_; }, message);
  newest_ = std::max(newest_, recorded + shift_);
  if (auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
    auto& T_published_recorded = T_published_recorded_[odometry->sensor];
    const auto newest = newest_odometry_.find(odometry->sensor);
    const bool goes_on = later_turn_ && newest != newest_odometry_.end() && !aligned_.contains(odometry->sensor);
    if (goes_on) T_published_recorded = newest->second * odometry->pose.inverse();
    aligned_.insert(odometry->sensor);
    odometry->pose = T_published_recorded * odometry->pose;
    newest_odometry_[odometry->sensor] = odometry->pose;
  }
  return message;
}

void Continuation::again() {
  first_.reset();
  later_turn_ = true;
  aligned_.clear();
}

common::Result<std::string> run_play(const PlayRequest& request, const std::atomic<bool>& stop,
                                     const std::function<void()>& on_started) {
  auto recording = open(request);
  if (!recording) return tl::unexpected(recording.error());
  const auto participant = idl::Participant::join(request.network);
  if (!participant) return tl::unexpected(participant.error());
  const auto publisher = RecordingPublisher::create(*participant, (*recording)->info());
  if (!publisher) return tl::unexpected(publisher.error());
  (*publisher)->wait_for_readers(request.wait);
  on_started();

  Pacer pacer(request.rate);
  Tally tally;
  Continuation continuation;
  std::optional<common::Nanoseconds> shift;
  for (int turn = 1; !stop;) {
    auto item = (*recording)->next();
    if (!item) return tl::unexpected(item.error());
    if (!*item) {
      if (turn++ == request.times) break;
      recording = open(request);
      if (!recording) return tl::unexpected(recording.error());
      continuation.again();
      continue;
    }
    if (const auto* rejected = std::get_if<common::RejectedMessage>(&**item)) {
      tally.add(*rejected);
      continue;
    }
    const auto message = continuation.next(std::get<common::SensorMessage>(std::move(**item)));
    const common::Nanoseconds stamp = common::stamp_of(message);
    if (!shift) {
      shift = request.stamps == PlayStamps::kNow ? clock_now() - stamp : 0;
      (*publisher)->introduce(stamp + *shift);
      std::this_thread::sleep_for(kSettle);
    }
    pacer.wait_for(stamp, stop);
    (*publisher)->publish(message, stamp + *shift);
    ++tally.sent[common::sensor_of(message)];
  }
  (*publisher)->finish(kLinger);
  const std::string text = in_words(request, tally, (*recording)->info(), **publisher);
  if (stop) return tl::unexpected(common::Error{common::ErrorKind::kInterrupted, "interrupted; " + text});
  return text;
}

}  // namespace slamfuse::service
