// SPDX-License-Identifier: BSD-3-Clause
// `slamfuse play` into `slamfuse record`: what comes back is what was played.
//
// SLAMFUSE_RECORDINGS: folder of recordings; its real/jackal/test_... and real/olin_neato are played too.
#include <cstdlib>
#include <filesystem>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/replay.hpp"
#include "idl/publications.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"
#include "system/recording_comparison.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class Record : public testing::Test {
 protected:
  Record() { fs::create_directories(folder_); }
  ~Record() override { fs::remove_all(folder_); }

  // Plays `more` of a recording into a bag.
  void record(const fs::path& recording, const std::vector<std::string>& more) {
    const pid_t recorder = start({SLAMFUSE_PROGRAM, "record", "-o", bag()});
    std::vector<std::string> words{SLAMFUSE_PROGRAM, "play", recording, "--wait", "20"};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(exit_status_of(start(words)), 0);
    std::this_thread::sleep_for(1s);
    kill(recorder, SIGINT);
    EXPECT_EQ(exit_status_of(recorder), 0);
  }

  void expect_same(common::Recording& played) {
    const auto recorded = common::open_recording(bag());
    ASSERT_TRUE(recorded) << recorded.error().message;
    const Comparison comparison = compare(played, **recorded);
    EXPECT_EQ(comparison.difference, "");
    for (const auto& [sensor, messages] : comparison.same) std::printf("%s: %zu identical\n", sensor.c_str(), messages);
  }

  fs::path bag() const { return folder_ / "bag"; }

  Network network_;
  fs::path folder_ = fs::temp_directory_path() / ("slamfuse-record-" + std::to_string(getpid()));
};

TEST_F(Record, TheDemoComesBackIdentical) {
  const std::string flat = SLAMFUSE_DATA_DIR "/flat";
  record(flat, {"--to", "4"});
  common::ReplayOptions options;
  options.to = 4.0;
  const auto played = common::replay(*common::open_recording(flat), options);
  ASSERT_TRUE(played);
  expect_same(**played);
}

// With DDS Security: who has no identity, or one of another authority, is not even known.
TEST_F(Record, TheUninvitedHearNothing) {
  const fs::path keystore = folder_ / "keystore";
  const fs::path other_keystore = folder_ / "other";
  for (const auto& store : {keystore, other_keystore}) {
    const std::string command = fmt::format("{} {} slamfuse > /dev/null", SLAMFUSE_KEYSTORE_SCRIPT, store.string());
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  const auto record_as = [&](const fs::path& store, const std::string& bag) {
    const idl::ScopedEnvironment enable("ROS_SECURITY_ENABLE", "true");
    const idl::ScopedEnvironment identity("ROS_SECURITY_KEYSTORE", store.c_str());
    return start({SLAMFUSE_PROGRAM, "record", "-o", folder_ / bag});
  };
  const pid_t foreign = record_as(other_keystore, "foreign");
  const pid_t uninvited = start({SLAMFUSE_PROGRAM, "record", "-o", folder_ / "uninvited"});
  {
    const idl::ScopedEnvironment enable("ROS_SECURITY_ENABLE", "true");
    const idl::ScopedEnvironment store("ROS_SECURITY_KEYSTORE", keystore.c_str());
    record(SLAMFUSE_DATA_DIR "/flat", {"--to", "2"});
  }
  for (const pid_t recorder : {uninvited, foreign}) {
    kill(recorder, SIGINT);
    EXPECT_EQ(exit_status_of(recorder), 0);
  }
  EXPECT_TRUE(common::open_recording(bag())) << "the invited one heard nothing either";
  EXPECT_FALSE(common::open_recording(folder_ / "uninvited"));
  EXPECT_FALSE(common::open_recording(folder_ / "foreign"));
}

class RecordReal : public Record, public testing::WithParamInterface<const char*> {};

TEST_P(RecordReal, ComesBackIdentical) {
  const char* const root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr) GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set: " << GetParam() << " was NOT played";
  const fs::path recording = fs::path(root) / GetParam();
  record(recording, {"--rate", "5"});
  const auto played = common::open_recording(recording);
  ASSERT_TRUE(played) << played.error().message;
  expect_same(**played);
}

INSTANTIATE_TEST_SUITE_P(Bags, RecordReal, testing::Values("real/jackal/test_2026-02-17-15-54-31", "real/olin_neato"));

}  // namespace
}  // namespace slamfuse::system
