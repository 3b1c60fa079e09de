// SPDX-License-Identifier: BSD-3-Clause
// kill -9 at random moments while the map is saved again and again: a whole map stands in its place every time.
//
// SLAMFUSE_KILLS: how often (default 20).
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "service/map_bundle.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

/// A bundle that takes a few milliseconds to write; all of its parts tell `round`.
common::Result<void> save(int round, const std::filesystem::path& path) {
  constexpr int kSide = 400;
  common::OccupancyGrid grid;
  grid.width = grid.height = kSide;
  grid.resolution = 0.05;
  grid.cells.assign(static_cast<std::size_t>(kSide) * kSide, static_cast<std::int8_t>(round % 2 == 0 ? 0 : 100));
  const std::string state = "round " + std::to_string(round) + std::string(200'000, 'x');
  MapBundle bundle;
  bundle.seed = static_cast<std::uint64_t>(round);
  bundle.grid = &grid;
  bundle.laser_state = state;
  bundle.landmarks.resize(1000);
  for (auto& landmark : bundle.landmarks) landmark.position.x() = 0.1 * round;
  bundle.trajectories["laser"] = common::Trajectory2(1000, common::StampedPose2{round, {}});
  return write_map_bundle(bundle, path);
}

[[noreturn]] void save_for_ever(int round, const std::filesystem::path& path) {
  while (save(round++, path)) {
  }
  std::_Exit(1);
}

int kills() {
  const char* text = std::getenv("SLAMFUSE_KILLS");
  return text == nullptr ? 20 : std::atoi(text);
}

TEST(MapSurvivesKill, AtAnyMoment) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "map";
  const auto start = std::chrono::steady_clock::now();
  ASSERT_TRUE(save(0, path));
  // So that a child is killed anywhere in its first saves, however fast the disk is.
  const std::chrono::duration<double> one_save = std::chrono::steady_clock::now() - start;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> seconds(0.0, 4.0 * one_save.count());
  std::uint64_t newest = 0;
  for (int i = 1; i <= kills(); ++i) {
    constexpr int kRoundsOfAChild = 1'000'000;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) save_for_ever(i * kRoundsOfAChild, path);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds(random)));
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "it could not save";

    const auto bundle = read_map_bundle(path);
    ASSERT_TRUE(bundle) << "kill " << i << ": " << bundle.error().message;
    const std::uint64_t round = bundle->summary.seed;
    EXPECT_GE(round, newest) << "an older map came back";
    newest = round;
    EXPECT_TRUE(bundle->laser_state.starts_with("round " + std::to_string(round) + "x"));
    EXPECT_EQ(bundle->grid->cells.front(), round % 2 == 0 ? 0 : 100);
    EXPECT_EQ(bundle->landmarks.size(), 1000u);
  }
  EXPECT_GT(newest, 0u);
}

}  // namespace
}  // namespace slamfuse::service
