// SPDX-License-Identifier: BSD-3-Clause
#include "service/record_command.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "common/ros2_bag_writer.hpp"
#include "idl/participant.hpp"
#include "idl/raw_reader.hpp"
#include "service/clock_now.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::Result;
using Clock = std::chrono::steady_clock;
using Topic = std::pair<std::string, std::string>;  // name, type

/// How long a request to stop, or a new topic, may go unnoticed.
constexpr auto kNap = 50ms;
/// What may wait for the disk [bytes]; more is dropped and counted.
constexpr std::size_t kLargestBacklog = std::size_t{1} << 28;

/// A message on its way to the disk.
struct Received {
  std::size_t topic = 0;
  common::Nanoseconds at = 0;
  std::vector<std::uint8_t> data;
};

/// What readers hand to the writer.
class Backlog {
 public:
  void push(Received message) {
    const std::lock_guard lock(mutex_);
    if (bytes_ + message.data.size() > kLargestBacklog) {
      ++dropped_;
      return;
    }
    bytes_ += message.data.size();
    messages_.push_back(std::move(message));
    filled_.notify_one();
  }

  std::optional<Received> pop(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!filled_.wait_for(lock, patience, [this] { return !messages_.empty(); })) return std::nullopt;
    std::optional<Received> message(std::move(messages_.front()));
    messages_.pop_front();
    bytes_ -= message->data.size();
    return message;
  }

  std::size_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::deque<Received> messages_;
  std::size_t bytes_ = 0;
  std::size_t dropped_ = 0;
};

/// A topic being received in a thread of its own, which ends with it and has then taken all that was there.
class TopicReceiver {
 public:
  TopicReceiver(idl::RawReader reader, std::size_t topic, Backlog& backlog)
      : reader_(std::make_shared<idl::RawReader>(std::move(reader))),
        thread_([reader = reader_, topic, &backlog](const std::stop_token& done) {
          while (true) {
            auto taken = reader->take(kNap);
            if (!taken) {
              std::this_thread::sleep_for(kNap);
            } else if (*taken) {
              backlog.push({topic, clock_now(), std::move(**taken)});
              continue;
            }
            if (done.stop_requested()) return;
          }
        }) {}

  std::size_t lost() const { return reader_->lost(); }
  bool refused_a_writer() const { return reader_->refused_a_writer(); }
  void finish() {
    thread_.request_stop();
    thread_.join();
  }

 private:
  std::shared_ptr<idl::RawReader> reader_;
  std::jthread thread_;
};

class Recorder {
 public:
  Recorder(const RecordRequest& request, idl::Participant participant, idl::Publications publications,
           common::Ros2BagWriter& bag, const std::function<void(const std::string&)>& tell)
      : participant_(std::move(participant)), publications_(std::move(publications)), bag_(bag), tell_(tell) {
    for (const auto& topic : request.topics) wanted_.insert(topic.starts_with('/') ? topic.substr(1) : topic);
  }

  /// Listens to topics that were not known before.
  Result<void> find_topics() {
    std::map<Topic, std::vector<idl::Publication>> found;
    for (auto& publication : publications_.look()) {
      if (!wanted_.empty() && !wanted_.contains(publication.topic)) continue;
      found[{publication.topic, publication.type}].push_back(std::move(publication));
    }
    for (const auto& [topic, publications] : found) {
      if (receivers_.contains(topic) || refused_.contains(topic)) continue;
      if (auto begun = begin(topic, publications); !begun) return begun;
    }
    return {};
  }

  Result<void> write_one() {
    const auto message = backlog_.pop(kNap);
    if (!message) return {};
    return bag_.write(message->topic, message->at, message->data);
  }

  /// Takes what is still there.
  Result<void> finish() {
    for (auto& [topic, receiver] : receivers_) receiver->finish();
    while (const auto message = backlog_.pop(0ms)) {
      if (auto written = bag_.write(message->topic, message->at, message->data); !written) return written;
    }
    return bag_.close();
  }

  std::string in_words(const std::filesystem::path& folder) const {
    std::string text =
        fmt::format("recorded {} messages of {} topics in {}\n", bag_.messages(), receivers_.size(), folder.string());
    std::size_t lost = 0;
    for (const auto& [topic, receiver] : receivers_) lost += receiver->lost();
    for (const auto& [topic, receiver] : receivers_) {
      if (!receiver->refused_a_writer()) continue;
      text +=
          fmt::format("  {}: a publisher came later that offers a weaker QoS, its messages are missing\n", topic.first);
    }
    if (lost > 0) text += fmt::format("  {} messages were lost on the way\n", lost);
    if (const std::size_t dropped = backlog_.dropped(); dropped > 0) {
      text += fmt::format("  {} messages were dropped: the disk did not keep up\n", dropped);
    }
    for (const auto& wanted : wanted_) {
      const auto heard = [&](const auto& receiver) { return receiver.first.first == wanted; };
      if (std::ranges::none_of(receivers_, heard)) text += fmt::format("  {}: nobody published it\n", wanted);
    }
    return text;
  }

 private:
  Result<void> begin(const Topic& topic, const std::vector<idl::Publication>& publications) {
    const auto& [name, type] = topic;
    const idl::RawReader::Demands demands{std::ranges::all_of(publications, &idl::Publication::reliable),
                                          std::ranges::all_of(publications, &idl::Publication::transient_local)};
    auto reader = idl::RawReader::create(participant_, name, type, demands);
    if (!reader) {  // such as a second type under one name
      tell_("/" + name + " (" + type + ") cannot be recorded: " + reader.error().message);
      refused_.insert(topic);
      return {};
    }
    const auto number = bag_.add_topic({"/" + name, type, offered_qos_profiles(publications)});
    if (!number) return tl::unexpected(number.error());
    receivers_.emplace(topic, std::make_unique<TopicReceiver>(*std::move(reader), *number, backlog_));
    tell_("recording /" + name + " (" + type + ")");
    return {};
  }

  idl::Participant participant_;
  idl::Publications publications_;
  common::Ros2BagWriter& bag_;
  const std::function<void(const std::string&)>& tell_;
  std::set<std::string> wanted_;
  std::set<Topic> refused_;
  Backlog backlog_;
  std::map<Topic, std::unique_ptr<TopicReceiver>> receivers_;  // they end before the backlog
};

}  // namespace

std::string offered_qos_profiles(const std::vector<idl::Publication>& publications) {
  // rmw's numbers. Discovery tells no history (3: unknown); deadline, lifespan and lease are without end.
  constexpr const char* kEndless = "\n    sec: 9223372036\n    nsec: 854775807\n";
  std::string yaml;
  for (const auto& publication : publications) {
    yaml += fmt::format(
        "- history: 3\n  depth: 0\n  reliability: {}\n  durability: {}\n  deadline:{}  lifespan:{}  liveliness: 1\n"
        "  liveliness_lease_duration:{}  avoid_ros_namespace_conventions: false\n",
        publication.reliable ? 1 : 2, publication.transient_local ? 1 : 2, kEndless, kEndless, kEndless);
  }
  return yaml;
}

Result<std::string> run_record(const RecordRequest& request, const std::function<void(const std::string&)>& tell,
                               const std::atomic<bool>& stop, const std::function<void()>& on_started) {
  auto participant = idl::Participant::join(request.network);
  if (!participant) return tl::unexpected(participant.error());
  auto publications = idl::Publications::create(*participant);
  if (!publications) return tl::unexpected(publications.error());
  const auto bag = common::Ros2BagWriter::create(request.out);
  if (!bag) return tl::unexpected(bag.error());
  on_started();
  Recorder recorder(request, *std::move(participant), *std::move(publications), **bag, tell);
  const auto end = request.duration
                       ? std::optional(Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                          std::chrono::duration<double>(*request.duration)))
                       : std::nullopt;
  auto look = Clock::now();
  while (!stop && (!end || Clock::now() < *end)) {
    if (Clock::now() >= look) {
      if (auto found = recorder.find_topics(); !found) return tl::unexpected(found.error());
      look = Clock::now() + kNap;
    }
    if (auto written = recorder.write_one(); !written) return tl::unexpected(written.error());
  }
  if (auto finished = recorder.finish(); !finished) return tl::unexpected(finished.error());
  return recorder.in_words(request.out);
}

}  // namespace slamfuse::service
