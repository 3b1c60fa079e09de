// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_saver.hpp"

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "service/map_bundle.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::PoseSource;

std::shared_ptr<const ModuleCheckpoint> laser_checkpoint(const std::string& state) {
  common::OccupancyGrid grid;
  grid.width = grid.height = 2;
  grid.resolution = 0.05;
  grid.cells = {0, 100, -1, 0};
  return std::make_shared<const ModuleCheckpoint>(
      ModuleCheckpoint{.grid = grid, .laser_state = state, .path = {{1, {1.0, 2.0, 0.0}}}});
}

void wait_for(const MapSaver& saver, std::size_t saved) {
  for (int i = 0; i < 1000 && saver.saved() < saved; ++i) std::this_thread::sleep_for(10ms);
}

TEST(MapSaver, TheNewestCheckpointIsOnDisk) {
  const TemporaryFolder folder;
  MapSaver saver(folder.path() / "map", 7, "DDS", [] { return std::nullopt; });
  saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("first"));
  wait_for(saver, 1);
  saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("second"));
  wait_for(saver, 2);
  const auto bundle = read_map_bundle(folder.path() / "map");
  ASSERT_TRUE(bundle) << bundle.error().message;
  EXPECT_EQ(bundle->laser_state, "second");
  EXPECT_EQ(bundle->summary.seed, 7u);
  EXPECT_TRUE(bundle->summary.incomplete);
  EXPECT_FALSE(saver.failure());
}

TEST(MapSaver, SavesNowWhenAsked) {
  const TemporaryFolder folder;
  MapSaver saver(folder.path() / "map", 7, "DDS", [] { return std::nullopt; });
  saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("first"));
  const auto ask = [&] { saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("second")); };
  EXPECT_TRUE(saver.save_new({PoseSource::kLaser}, ask, 5s));
  EXPECT_EQ(read_map_bundle(folder.path() / "map")->laser_state, "second");
}

TEST(MapSaver, TellsWhoHadNothingNewToSave) {
  const TemporaryFolder folder;
  MapSaver saver(folder.path() / "map", 7, "DDS", [] { return std::nullopt; });
  const auto ask = [&] { saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("state")); };
  const auto saved = saver.save_new({PoseSource::kLaser, PoseSource::kVisual}, ask, 100ms);
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().message.find("the visual half made no pose"), std::string::npos);
}

TEST(MapSaver, TellsWhyItCannotSave) {
  const TemporaryFolder folder;
  MapSaver saver("/proc/no/such/map", 1, "DDS", [] { return std::nullopt; });
  saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("state"));
  for (int i = 0; i < 1000 && !saver.failure(); ++i) std::this_thread::sleep_for(10ms);
  ASSERT_TRUE(saver.failure());
  EXPECT_EQ(saver.saved(), 0u);
  const auto ask = [&] { saver.on_checkpoint(PoseSource::kLaser, laser_checkpoint("state")); };
  EXPECT_FALSE(saver.save_new({PoseSource::kLaser}, ask, 5s));
}

}  // namespace
}  // namespace slamfuse::service
