// SPDX-License-Identifier: BSD-3-Clause
// A stranger on the network: listens to what a run publishes and writes down what arrived, one line a message. Ends
// when the publisher has gone.
//
//     dds_receiver FOLDER
//
// FOLDER/messages.txt: "pose", "tf", "path" and "map" lines; FOLDER/map.raw: the cells of the last map. FOLDER/ready
// appears when it listens.
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "idl/domain_settings.hpp"
#include "idl/participant.hpp"
#include "idl/reader.hpp"

namespace {

using namespace slamfuse::idl;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kGiveUp = 120s;
constexpr auto kQuiet = 500ms;  // without a message after the publisher left: nothing is under way any more

void write_header(std::ostream& out, const char* kind, const Header& header) {
  out << kind << ' ' << header.stamp.sec * 1'000'000'000LL + header.stamp.nanosec << ' ' << text_of(header.frame_id);
}

void write(std::ostream& out, const PoseWithCovarianceStamped& message) {
  const auto& pose = message.pose.pose;
  write_header(out, "pose", message.header);
  out << ' ' << pose.position.x << ' ' << pose.position.y << ' ' << pose.orientation.z << ' ' << pose.orientation.w
      << ' ' << message.pose.covariance[0] << ' ' << message.pose.covariance[35] << '\n';
}

void write(std::ostream& out, const TFMessage& message) {
  for (std::uint32_t i = 0; i < message.transforms._length; ++i) {
    const TransformStamped& transform = message.transforms._buffer[i];
    write_header(out, "tf", transform.header);
    out << ' ' << text_of(transform.child_frame_id) << ' ' << transform.transform.translation.x << ' '
        << transform.transform.translation.y << ' ' << transform.transform.rotation.z << ' '
        << transform.transform.rotation.w << '\n';
  }
}

void write(std::ostream& out, const OccupancyGrid& message, const std::filesystem::path& cells) {
  write_header(out, "map", message.header);
  out << ' ' << message.info.resolution << ' ' << message.info.width << ' ' << message.info.height << ' '
      << message.info.origin.position.x << ' ' << message.info.origin.position.y << '\n';
  std::ofstream(cells, std::ios::binary)
      .write(reinterpret_cast<const char*>(message.data._buffer), static_cast<std::streamsize>(message.data._length));
}

void write(std::ostream& out, const Path& message) {
  write_header(out, "path", message.header);
  out << ' ' << message.poses._length << '\n';
}

// Hands every message that is there to `use`; whether there was one.
template <class T, class Use>
bool drain(Reader<T>& reader, const Use& use) {
  bool any = false;
  for (auto taken = reader.take(); taken && *taken; taken = reader.take(), any = true) use(***taken);
  return any;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  const auto settings = domain_from_environment(Network::kLoopback);
  if (!settings) return 3;
  const auto participant = Participant::create(*settings);
  if (!participant) return 3;
  auto poses = Reader<PoseWithCovarianceStamped>::create(*participant, "slamfuse/pose", QosProfile::kTransformInput);
  auto transforms = Reader<TFMessage>::create(*participant, "tf", QosProfile::kTransformInput);
  auto paths = Reader<Path>::create(*participant, "slamfuse/path/fused", QosProfile::kTransformInput);
  auto maps = Reader<OccupancyGrid>::create(*participant, "map", QosProfile::kLatchedOutput);
  if (!poses || !transforms || !paths || !maps) return 3;

  std::ofstream out(folder / "messages.txt");
  out.precision(17);
  std::ofstream(folder / "ready") << '\n';
  const auto started = Clock::now();
  auto last_message = started;
  bool met = false;
  while (Clock::now() - started < kGiveUp) {
    // Waits on the busiest topic, a millisecond at a time; the others follow at once.
    bool any = false;
    if (const auto pose = poses->take(1ms); pose && *pose) {
      write(out, ***pose);
      any = true;
    }
    any |= drain(*poses, [&](const auto& message) { write(out, message); });
    any |= drain(*transforms, [&](const auto& message) { write(out, message); });
    any |= drain(*paths, [&](const auto& message) { write(out, message); });
    any |= drain(*maps, [&](const auto& message) { write(out, message, folder / "map.raw"); });
    if (any) last_message = Clock::now();
    met |= poses->matched_writers() > 0;
    if (met && poses->matched_writers() == 0 && Clock::now() - last_message > kQuiet) return 0;
  }
  return 1;
}
