// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_topics.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string_view>
#include <tuple>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/ros_conversions.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kTruthRole = "truth";
constexpr const char* kNone = "none";

std::string_view last_part(std::string_view topic) { return topic.substr(topic.rfind('/') + 1); }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// Whether a topic's name says that its poses are true ones.
bool tells_truth(const std::string& topic) {
  constexpr std::array kWords{"vrpn", "vicon", "optitrack", "qualisys", "mocap", "truth", "groundtruth"};
  const std::string name = lower(topic);
  return std::any_of(kWords.begin(), kWords.end(),
                     [&](const char* word) { return name.find(word) != std::string::npos; });
}

/// The sensor kind of a role such as "laser0"; nothing for any other word. There is one odometry only: all who use it
/// take every message of it for the same wheels.
std::optional<SensorKind> kind_of_role(const std::string& role) {
  if (role == "odom0") return SensorKind::kOdometry;
  for (const auto& [prefix, kind] :
       {std::pair<std::string_view, SensorKind>{"laser", SensorKind::kLaser}, {"cam", SensorKind::kCamera}}) {
    if (!role.starts_with(prefix) || role.size() == prefix.size()) continue;
    if (role.find_first_not_of("0123456789", prefix.size()) == std::string::npos) return kind;
  }
  return std::nullopt;
}

bool fits(RosType type, SensorKind kind) {
  switch (kind) {
    case SensorKind::kLaser:
      return type == RosType::kLaserScan;
    case SensorKind::kOdometry:
      return type == RosType::kOdometry || type == RosType::kTransforms;
    case SensorKind::kCamera:
      return type == RosType::kImage || type == RosType::kCompressedImage;
    case SensorKind::kImu:
    case SensorKind::kPose:
      return false;
  }
  return false;
}

std::optional<std::size_t> find_topic(const RosSurvey& survey, const std::string& name) {
  for (std::size_t i = 0; i < survey.topics.size(); ++i) {
    if (survey.topics[i].topic.name == name) return i;
  }
  return std::nullopt;
}

/// The topic an option names.
Result<std::size_t> named_topic(const RosSurvey& survey, const std::string& role, const std::string& name,
                                const auto& fits_role) {
  const auto topic = find_topic(survey, name);
  if (topic && fits_role(survey.topics[*topic].type)) return *topic;
  std::vector<std::string> possible;
  for (const RosTopicSummary& summary : survey.topics) {
    if (fits_role(summary.type)) possible.push_back(summary.topic.name);
  }
  return usage_error(fmt::format("topic of {}: {} {} (possible here: {})", role, name,
                                 topic ? "is of type " + survey.topics[*topic].topic.type : "is not in the recording",
                                 possible.empty() ? "none" : fmt::format("{}", fmt::join(possible, ", "))));
}

class TopicChoice {
 public:
  TopicChoice(const RosSurvey& survey, const RecordingOptions& options) : survey_(survey), options_(options) {}

  Result<RosTopics> choose() {
    if (auto checked = read_roles(); !checked) return tl::unexpected(checked.error());
    choose_odometry();
    choose_base_frame();
    if (!by_kind_.contains(SensorKind::kOdometry)) choose_odometry_by_tf();
    finish_odometry_by_tf();
    choose_lasers();
    choose_cameras();
    add_notes();
    return std::move(chosen_);
  }

 private:
  Result<void> read_roles() {
    for (const auto& [role, name] : options_.topics) {
      if (role == kTruthRole) continue;
      const auto kind = kind_of_role(role);
      if (!kind) {
        return usage_error(fmt::format("topic of {}: known are laserN, odom0, camN and {}", role, kTruthRole));
      }
      by_kind_.insert(*kind);
      if (name == kNone) continue;
      const auto topic = named_topic(survey_, role, name, [&](RosType type) { return fits(type, *kind); });
      if (!topic) return tl::unexpected(topic.error());
      add(role, *kind, *topic);
    }
    return {};
  }

  void add(const std::string& name, SensorKind kind, std::size_t topic) {
    const RosTopicSummary& summary = survey_.topics[topic];
    RosSensor sensor{name, kind, topic, std::nullopt, summary.type == RosType::kTransforms, summary.frame};
    if (kind == SensorKind::kOdometry) sensor.frame = summary.child_frame;
    if (kind == SensorKind::kCamera) sensor.camera_info = camera_info_of(summary.topic.name);
    chosen_.sensors.push_back(std::move(sensor));
  }

  /// The topics of a type that have a message, best first: by `rank` (smaller is better), messages, name.
  std::vector<std::size_t> ranked(RosType type, const auto& rank) const {
    std::vector<std::size_t> topics;
    for (std::size_t i = 0; i < survey_.topics.size(); ++i) {
      if (survey_.topics[i].type == type && survey_.topics[i].messages > 0) topics.push_back(i);
    }
    const auto key = [&](std::size_t i) {
      const RosTopicSummary& summary = survey_.topics[i];
      return std::tuple(rank(summary), -static_cast<std::int64_t>(summary.messages), summary.topic.name);
    };
    std::sort(topics.begin(), topics.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
    return topics;
  }

  void choose_odometry() {
    if (by_kind_.contains(SensorKind::kOdometry)) return;
    const auto rank = [](const RosTopicSummary& summary) {
      return std::pair(last_part(summary.topic.name) != "odom", summary.frame == "map");
    };
    std::vector<std::string> others;
    for (const std::size_t topic : ranked(RosType::kOdometry, rank)) {
      const std::string& name = survey_.topics[topic].topic.name;
      if (tells_truth(name)) continue;
      if (by_kind_.insert(SensorKind::kOdometry).second) {
        add("odom0", SensorKind::kOdometry, topic);
      } else {
        others.push_back(name);
      }
    }
    if (!others.empty()) note("left alone, one odometry is enough: {}", fmt::join(others, ", "));
  }

  void choose_base_frame() {
    chosen_.base_frame = options_.base_frame;
    for (const char* frame : {"base_link", "base_footprint", "base"}) {
      if (chosen_.base_frame.empty() && survey_.frames.knows(frame)) chosen_.base_frame = frame;
    }
    for (const RosSensor& sensor : chosen_.sensors) {
      if (sensor.kind == SensorKind::kOdometry && chosen_.base_frame.empty()) chosen_.base_frame = sensor.frame;
    }
    if (chosen_.base_frame.empty()) chosen_.base_frame = "base_link";
  }

  void choose_odometry_by_tf() {
    if (!moved_frame().empty()) {
      by_kind_.insert(SensorKind::kOdometry);
      chosen_.sensors.push_back({"odom0", SensorKind::kOdometry, 0, std::nullopt, true, {}});
    }
  }

  /// The frame moved in kOdometryFrame whose pose is that of the base; empty when there is none.
  std::string moved_frame() const {
    if (survey_.moved_by_tf.contains(chosen_.base_frame)) return chosen_.base_frame;
    for (const auto& [frame, summary] : survey_.moved_by_tf) {
      if (survey_.frames.transform(frame, chosen_.base_frame)) return frame;
    }
    return {};
  }

  void finish_odometry_by_tf() {
    for (RosSensor& sensor : chosen_.sensors) {
      if (sensor.by_tf) sensor.frame = moved_frame();
    }
  }

  void choose_lasers() {
    if (by_kind_.contains(SensorKind::kLaser)) return;
    std::size_t number = 0;
    const auto rank = [](const RosTopicSummary& summary) { return last_part(summary.topic.name) != "scan"; };
    for (const std::size_t topic : ranked(RosType::kLaserScan, rank)) {
      add("laser" + std::to_string(number++), SensorKind::kLaser, topic);
    }
  }

  void choose_cameras() {
    if (by_kind_.contains(SensorKind::kCamera)) return;
    std::vector<std::size_t> topics;
    std::set<std::size_t> infos;
    const auto consider = [&](std::size_t topic, bool usable) {
      const std::string& name = survey_.topics[topic].topic.name;
      const auto info = camera_info_of(name);
      if (!usable || !info) {
        note("{} is left alone: {}", name, !usable ? "not 8 bit gray or colour" : "no camera_info beside it");
      } else if (infos.insert(*info).second) {
        topics.push_back(topic);
      }
    };
    const auto by_name = [](const RosTopicSummary& summary) { return summary.topic.name; };
    for (const std::size_t topic : ranked(RosType::kImage, by_name)) {
      consider(topic, is_gray_or_colour(survey_.topics[topic].encoding));
    }
    for (const std::size_t topic : ranked(RosType::kCompressedImage, by_name)) {
      consider(topic, last_part(survey_.topics[topic].topic.name) != "compressedDepth");
    }
    std::sort(topics.begin(), topics.end(), [&](std::size_t a, std::size_t b) {
      return survey_.topics[a].topic.name < survey_.topics[b].topic.name;
    });
    std::size_t number = 0;
    for (const std::size_t topic : topics) add("cam" + std::to_string(number++), SensorKind::kCamera, topic);
  }

  std::optional<std::size_t> camera_info_of(const std::string& image) const {
    const auto info = find_topic(survey_, camera_info_topic(image));
    return info && survey_.topics[*info].camera ? info : std::nullopt;
  }

  template <class... Values>
  void note(fmt::format_string<Values...> text, Values&&... values) {
    chosen_.notes.push_back(fmt::format(text, std::forward<Values>(values)...));
  }

  void add_notes() {
    std::sort(chosen_.sensors.begin(), chosen_.sensors.end(),
              [](const RosSensor& a, const RosSensor& b) { return a.name < b.name; });
    for (const RosSensor& sensor : chosen_.sensors) {
      if (sensor.by_tf) {
        note("{} is the move of {} in {} that tf tells", sensor.name, sensor.frame, kOdometryFrame);
        continue;
      }
      const RosTopicSummary& summary = survey_.topics[sensor.topic];
      note("{} is {} ({}, frame {})", sensor.name, summary.topic.name, summary.topic.type,
           sensor.frame.empty() ? "not told" : sensor.frame);
    }
    std::vector<std::string> unknown;
    for (const RosTopicSummary& summary : survey_.topics) {
      if (summary.type != RosType::kOther || summary.messages == 0) continue;
      unknown.push_back(fmt::format("{} ({}, {} messages)", summary.topic.name, summary.topic.type, summary.messages));
    }
    if (!unknown.empty()) note("of types that are not read: {}", fmt::join(unknown, ", "));
  }

  const RosSurvey& survey_;
  const RecordingOptions& options_;
  std::set<SensorKind> by_kind_;  ///< whose topics are chosen
  RosTopics chosen_;
};

}  // namespace

std::string camera_info_topic(std::string image_topic) {
  if (image_topic.ends_with(kCompressedEnding)) image_topic.erase(image_topic.rfind('/'));
  return image_topic.substr(0, image_topic.rfind('/') + 1) + "camera_info";
}

Result<RosTopics> choose_ros_topics(const RosSurvey& survey, const RecordingOptions& options) {
  return TopicChoice(survey, options).choose();
}

Result<std::optional<std::size_t>> choose_ros_truth(const RosSurvey& survey, const RecordingOptions& options) {
  const auto holds_poses = [](RosType type) { return type == RosType::kPoseStamped || type == RosType::kOdometry; };
  if (const auto named = options.topics.find(kTruthRole); named != options.topics.end()) {
    if (named->second == kNone) return std::nullopt;
    const auto topic = named_topic(survey, kTruthRole, named->second, holds_poses);
    if (!topic) return tl::unexpected(topic.error());
    return *topic;
  }
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < survey.topics.size(); ++i) {
    const RosTopicSummary& summary = survey.topics[i];
    if (!holds_poses(summary.type) || summary.messages == 0 || !tells_truth(summary.topic.name)) continue;
    if (!best || summary.messages > survey.topics[*best].messages) best = i;
  }
  return best;
}

}  // namespace slamfuse::common
