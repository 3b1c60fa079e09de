// SPDX-License-Identifier: BSD-3-Clause
// Localisation in a saved map: the map of the demo recording, and a later stretch of the same drive.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/tum.hpp"
#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;

/// The map of the whole demo recording, made once.
class Localization : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new Scratch;
    const Outcome made =
        run_program({"run", flat().string(), "-o", (*scratch_ / "mapped").string(), "--modules", "laser"});
    ASSERT_EQ(made.exit_status, 0) << made.err;
  }
  static void TearDownTestSuite() {
    delete scratch_;
    scratch_ = nullptr;
  }

  static fs::path mapped() { return *scratch_ / "mapped"; }

  static Outcome localize(const fs::path& map, const std::string& out, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"run",       flat().string(),
                                       "-o",        (*scratch_ / out).string(),
                                       "--mode",    "localization",
                                       "--map",     map.string(),
                                       "--modules", "laser",
                                       "--from",    "40",
                                       "--to",      "55"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  static fs::path out(const std::string& name) { return *scratch_ / name; }

  /// How far the poses of a run are from those of the mapping run at the same scans [m]; its poses must be enough.
  static double worst_distance(const std::string& run) {
    const auto found = common::read_trajectory(out(run) / "laser.tum");
    const auto mapped_path = common::read_trajectory(mapped() / "laser_final.tum");
    EXPECT_TRUE(found && mapped_path);
    if (!found || !mapped_path) return HUGE_VAL;
    EXPECT_GT(found->size(), 50U) << "of some 90 scans";
    const auto reference = common::to_planar(*mapped_path);
    double worst = 0.0;
    for (const auto& pose : common::to_planar(*found)) {
      const auto truth = common::pose_at(reference, pose.stamp, common::kNanosecondsPerSecond);
      if (!truth) continue;
      worst = std::max(worst, std::hypot(pose.pose.x - truth->x, pose.pose.y - truth->y));
    }
    return worst;
  }

 private:
  static Scratch* scratch_;
};

Scratch* Localization::scratch_ = nullptr;

TEST_F(Localization, FindsItselfAnywhereInTheMapAndHandsTheMapOnAsItWas) {
  const Outcome outcome = localize(mapped() / "map", "found");
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_LT(worst_distance("found"), 0.1);
  for (const char* file : {"grid.pgm", "grid.yaml", "laser_state.bin"}) {
    EXPECT_EQ(read_text(out("found") / "map" / file), read_text(mapped() / "map" / file)) << file;
  }
}

TEST_F(Localization, WritesNoPoseWhileItSearches) {
  ASSERT_EQ(localize(mapped() / "map", "searching").exit_status, 0);
  const auto online = common::read_trajectory(out("searching") / "laser.tum");
  const auto final_path = common::read_trajectory(out("searching") / "laser_final.tum");
  ASSERT_TRUE(online && final_path);
  EXPECT_LT(online->size(), final_path->size()) << "the path before the first fix is known in hindsight only";
}

TEST_F(Localization, GivesTheSameBytesWithAnyNumberOfThreads) {
  ASSERT_EQ(localize(mapped() / "map", "one", {"--threads", "1"}).exit_status, 0);
  ASSERT_EQ(localize(mapped() / "map", "three", {"--threads", "3"}).exit_status, 0);
  for (const char* file : {"laser.tum", "laser_final.tum", "fused.tum", "status.csv"}) {
    EXPECT_EQ(read_text(out("one") / file), read_text(out("three") / file)) << file;
  }
}

TEST_F(Localization, TakesAMapOfNav2) {
  const fs::path folder = out("nav2");
  fs::create_directory(folder);
  fs::copy_file(mapped() / "map/grid.pgm", folder / "grid.pgm");
  fs::copy_file(mapped() / "map/grid.yaml", folder / "map.yaml");
  for (const auto& map : {folder, folder / "map.yaml"}) {
    const Outcome outcome = localize(map, "in_nav2");
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    EXPECT_LT(worst_distance("in_nav2"), 0.15) << "a plain grid knows walls to half a cell";
    fs::remove_all(out("in_nav2"));
  }
}

TEST_F(Localization, RefusesWhatIsNoMap) {
  const fs::path folder = out("no_map");
  fs::create_directory(folder);
  EXPECT_EQ(localize(folder, "refused").exit_status, 3);
  EXPECT_EQ(localize(out("nothing there"), "refused").exit_status, 3);
  write_text(folder / "map.yaml", "image: grid.pgm\nresolution: -1\norigin: [0, 0, 0]\n");
  const Outcome outcome = localize(folder, "refused");
  EXPECT_EQ(outcome.exit_status, 3);
  EXPECT_NE(outcome.err.find("resolution"), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out("refused")));
}

}  // namespace
}  // namespace slamfuse::system
