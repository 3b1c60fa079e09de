// SPDX-License-Identifier: BSD-3-Clause
// DDS Security between processes: what is on the wire, and what the uninvited can put in. In a network namespace of
// its own, so that nobody else's datagrams are heard.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/recording.hpp"
#include "common/replay.hpp"
#include "system/child_process.hpp"
#include "system/datagram_capture.hpp"
#include "system/hosts.hpp"
#include "system/network.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const std::string kFlat = SLAMFUSE_DATA_DIR "/flat";

// Some readings of the first scan played, as they are in a message.
std::string readings() {
  common::ReplayOptions options;
  options.only_sensors = {"laser0"};
  const auto recording = common::replay(*common::open_recording(kFlat), options);
  for (auto item = (*recording)->next(); item && *item; item = (*recording)->next()) {
    const auto* message = std::get_if<common::SensorMessage>(&**item);
    const auto* scan = message == nullptr ? nullptr : std::get_if<common::LaserScan>(message);
    if (scan == nullptr) continue;
    std::string bytes(8 * sizeof(float), '\0');
    std::memcpy(bytes.data(), scan->ranges.data() + scan->ranges.size() / 2, bytes.size());
    return bytes;
  }
  return {};
}

// What tells of our topics: names, types, frames, and what was measured.
std::map<std::string, std::string> telltales() {
  return {{"topic in", "rt/scan"},
          {"topic out", "slamfuse/pose"},
          {"service", "save_map"},
          {"type in", "LaserScan"},
          {"type out", "PoseWithCovarianceStamped"},
          {"node", "ros_discovery_info"},
          {"frame", "base_link"},
          {"readings", readings()}};
}

class Secured : public testing::Test {
 protected:
  void SetUp() override {
    std::string why_not;
    hosts_ = Hosts::create({"here"}, why_not);
    if (!hosts_ || !hosts_->enter("here")) {
      std::fprintf(stderr, "NOT TESTED: what is on the wire under security: %s\n", why_not.c_str());
      GTEST_SKIP() << why_not;
    }
    fs::create_directories(folder_);
    for (const char* store : {"ours", "theirs"}) {
      const std::string command =
          fmt::format("{} {} slamfuse > /dev/null", SLAMFUSE_KEYSTORE_SCRIPT, (folder_ / store).string());
      ASSERT_EQ(std::system(command.c_str()), 0);
    }
  }
  void TearDown() override {
    if (hosts_) hosts_->leave();
    fs::remove_all(folder_);
  }

  pid_t serve(const std::string& out) const {
    return start({SLAMFUSE_PROGRAM, "serve", "-o", folder_ / out, "--modules", "laser"});
  }
  static pid_t play(const std::string& wait) {
    return start({SLAMFUSE_PROGRAM, "play", kFlat, "--to", "4", "--wait", wait});
  }

  // All that is on the wire while a robot drives with the service, one datagram after the other.
  std::vector<Datagram> drive(const std::string& out) const {
    const auto capture = DatagramCapture::start("lo", 100'000);
    EXPECT_TRUE(capture);
    const pid_t service = serve(out);
    EXPECT_EQ(exit_status_of(play("6")), 0);
    kill(service, SIGINT);
    EXPECT_EQ(exit_status_of(service), 0) << "the service heard nothing";
    return capture->stop();
  }

  static std::size_t occurrences(const std::vector<Datagram>& datagrams, const std::string& text) {
    return static_cast<std::size_t>(std::ranges::count_if(datagrams, [&](const Datagram& datagram) {
      const auto& bytes = datagram.payload;
      return std::search(bytes.begin(), bytes.end(), text.begin(), text.end(), [](std::uint8_t byte, char letter) {
               return byte == static_cast<std::uint8_t>(letter);
             }) != bytes.end();
    }));
  }

  const fs::path folder_ = fs::temp_directory_path() / ("slamfuse-secured-" + std::to_string(getpid()));
  std::unique_ptr<Hosts> hosts_;
  Network network_;
};

TEST_F(Secured, NothingOfOurTopicsIsPlain) {
  // Without security all of it is there to be read: the capture works.
  const auto open = drive("open");
  for (const auto& [what, text] : telltales()) EXPECT_GT(occurrences(open, text), 0u) << what;

  const idl::ScopedEnvironment enable("ROS_SECURITY_ENABLE", "true");
  const idl::ScopedEnvironment keystore("ROS_SECURITY_KEYSTORE", (folder_ / "ours").c_str());
  const auto secured = drive("secured");
  EXPECT_GT(secured.size(), 100u);
  for (const auto& [what, text] : telltales()) EXPECT_EQ(occurrences(secured, text), 0u) << what;
  std::printf("%zu datagrams open, %zu secured\n", open.size(), secured.size());
}

TEST_F(Secured, TheUninvitedPutNothingIn) {
  const auto as = [&](const char* store, const std::function<pid_t()>& what) {
    const idl::ScopedEnvironment enable("ROS_SECURITY_ENABLE", "true");
    const idl::ScopedEnvironment keystore("ROS_SECURITY_KEYSTORE", (folder_ / store).c_str());
    return what();
  };
  const pid_t service = as("ours", [&] { return serve("out"); });
  // One without identity, one with that of another authority.
  const pid_t unknown = play("3");
  const pid_t stranger = as("theirs", [] { return play("3"); });
  exit_status_of(unknown);
  exit_status_of(stranger);
  kill(service, SIGINT);
  EXPECT_EQ(exit_status_of(service), 130) << "it was to hear no sensor";
}

}  // namespace
}  // namespace slamfuse::system
