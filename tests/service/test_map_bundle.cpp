// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_bundle.hpp"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "service/map_yaml.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

const common::OccupancyGrid& small_grid() {
  static const common::OccupancyGrid grid{0.05, 2, 1, {0.0, 0.0}, {0, 100}};
  return grid;
}

MapBundle small_bundle() {
  MapBundle bundle;
  bundle.program_version = "1.2.3";
  bundle.seed = 9;
  bundle.recording = "a \"quoted\" name: with colon";
  bundle.grid = &small_grid();
  bundle.laser_state = std::string_view("state\0with zero", 15);
  bundle.landmarks.resize(3);
  bundle.alignment.emplace();
  bundle.alignment->accepted = true;
  bundle.alignment->map.linear << 0.5, -0.25, 0.25, 0.5;
  bundle.alignment->map.translation = {1.0 / 3.0, 2.0};
  bundle.alignment->mapping = fusion::to_mapping_matrix(bundle.alignment->map);
  bundle.alignment->method = fusion::AlignmentMethod::kRigid;
  bundle.alignment->heldout_rmse = 0.0125;
  bundle.alignment->forward_rmse = 1.0 / 7.0;
  bundle.alignment->heading_rmse = 0.003;
  bundle.trajectories["laser"] = {{1, {1.0, 2.0, 0.5}}};
  return bundle;
}

class MapBundleFiles : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(write_map_bundle(small_bundle(), map()).has_value()); }
  fs::path map() const { return temporary_ / "map"; }

  void replace_in_yaml(const std::string& from, const std::string& to) const {
    std::string yaml = content_of(map() / "map.yaml");
    const std::size_t at = yaml.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    yaml.replace(at, from.size(), to);
    put(map() / "map.yaml", sealed(yaml.substr(0, yaml.rfind("crc32: "))));
  }

  void expect_refused(const std::string& word) const {
    const auto bundle = read_map_bundle(map());
    ASSERT_FALSE(bundle.has_value());
    EXPECT_EQ(bundle.error().kind, common::ErrorKind::kInvalidInput);
    EXPECT_THAT(bundle.error().message, HasSubstr(word));
  }

  TemporaryFolder temporary_;
};

TEST_F(MapBundleFiles, AreReadBack) {
  const auto bundle = read_map_bundle(map());
  ASSERT_TRUE(bundle.has_value()) << bundle.error().message;
  EXPECT_EQ(bundle->summary.program_version, "1.2.3");
  EXPECT_EQ(bundle->summary.seed, 9U);
  EXPECT_EQ(bundle->summary.recording, small_bundle().recording);
  ASSERT_TRUE(bundle->summary.alignment);
  EXPECT_FALSE(bundle->summary.incomplete);
  EXPECT_EQ(bundle->laser_state, small_bundle().laser_state);
  EXPECT_EQ(bundle->landmarks.size(), 3U);
  ASSERT_TRUE(bundle->grid.has_value());
  EXPECT_EQ(bundle->grid->cells, small_grid().cells);
}

TEST_F(MapBundleFiles, SayHowFarTheAlignmentIsOff) {
  const auto bundle = read_map_bundle(map());
  ASSERT_TRUE(bundle.has_value() && bundle->summary.alignment);
  EXPECT_EQ(bundle->summary.alignment->method, fusion::AlignmentMethod::kRigid);
  EXPECT_EQ(bundle->summary.alignment->heldout_rmse, 0.0125);
  EXPECT_EQ(bundle->summary.alignment->forward_rmse, 1.0 / 7.0);
  EXPECT_EQ(bundle->summary.alignment->heading_rmse, 0.003);
}

/// Not as if it were free of error.
TEST_F(MapBundleFiles, FromBeforeErrorsWereSavedHaveSome) {
  replace_in_yaml("    heldout_rmse: 0.0125\n", "");

  const auto bundle = read_map_bundle(map());

  ASSERT_TRUE(bundle.has_value() && bundle->summary.alignment);
  EXPECT_GT(bundle->summary.alignment->heldout_rmse, 0.01);
  EXPECT_GT(bundle->summary.alignment->heading_rmse, 0.01);
}

TEST_F(MapBundleFiles, WithAnImpossibleErrorAreRefused) {
  replace_in_yaml("heldout_rmse: 0.0125", "heldout_rmse: -1");
  expect_refused("heldout_rmse");
}

TEST_F(MapBundleFiles, ReplaceAnOlderBundleWithoutALeftover) {
  MapBundle second = small_bundle();
  second.landmarks.clear();
  ASSERT_TRUE(write_map_bundle(second, map()).has_value());
  EXPECT_THAT(names_in(temporary_.path()), ElementsAre("map"));
  EXPECT_THAT(names_in(map()), ElementsAre("grid.pgm", "grid.yaml", "laser.tum", "laser_state.bin", "map.yaml"));
}

TEST_F(MapBundleFiles, HoldAModelForOtherProgramsWhenThereAreKeyframes) {
  MapBundle bundle = small_bundle();
  bundle.keyframes.push_back({"cam0", 5, {}, {}});
  bundle.cameras["cam0"] = {};
  ASSERT_TRUE(write_map_bundle(bundle, map()).has_value());
  EXPECT_THAT(names_in(map() / "colmap"), ElementsAre("cameras.txt", "images.txt", "points3D.txt"));
  EXPECT_EQ(YAML::LoadFile((map() / "map.yaml").string())["visual_maps"][0]["colmap"].as<std::string>(), "colmap");
  ASSERT_TRUE(read_map_bundle(map()).has_value());
  put(map() / "colmap/images.txt", "");
  expect_refused("colmap/images.txt");
}

TEST_F(MapBundleFiles, SayTheMappingMatrixWithAllItsDigits) {
  const YAML::Node link = YAML::LoadFile((map() / "map.yaml").string())["links"][0];
  EXPECT_EQ(link["verdict"].as<std::string>(), "accepted");
  EXPECT_EQ(link["G_LV"].size(), 16U);
  EXPECT_EQ(link["G_LV"][0].as<double>(), 0.5);
  EXPECT_EQ(link["G_LV"][3].as<double>(), 1.0 / 3.0);
  for (const char* factor :
       {"T_traj_laser", "R_laser", "T_curv_laser", "T_ess", "T_curv_visual", "R_visual", "T_traj_visual"}) {
    EXPECT_EQ(link[factor].size(), 16U) << factor;
  }
}

TEST_F(MapBundleFiles, AreRefusedWhenOneIsCut) {
  const std::string state = content_of(map() / "laser_state.bin");
  put(map() / "laser_state.bin", state.substr(1));
  expect_refused("laser_state.bin");
}

TEST_F(MapBundleFiles, AreRefusedWhenOneIsAltered) {
  std::string state = content_of(map() / "laser_state.bin");
  state[3] = 'X';
  put(map() / "laser_state.bin", state);
  expect_refused("checksum");
}

TEST_F(MapBundleFiles, AreRefusedWhenOneIsMissing) {
  fs::remove(map() / "landmarks.bin");
  expect_refused("landmarks.bin");
}

TEST_F(MapBundleFiles, AreRefusedWhenNewer) {
  replace_in_yaml("version: 1\n", "version: 2\n");
  expect_refused("format version 2");
}

TEST_F(MapBundleFiles, AreRefusedWhenOversized) {
  replace_in_yaml("bytes: 15,", "bytes: 99999999999999,");
  expect_refused("99999999999999");
}

TEST_F(MapBundleFiles, AreRefusedWhenANameLeadsOutOfTheFolder) {
  std::string last = "laser_state.bin";
  for (const std::string name : {"../laser_state.bin", "/laser_state.bin", "colmap/../../laser_state.bin", "a/b/c",
                                 "./laser_state.bin", "colmap//laser_state.bin", "colmap/", "..\\\\laser_state.bin"}) {
    replace_in_yaml("name: " + last, "name: " + name);
    expect_refused("is not the name of a file of the map");
    last = name;
  }
}

TEST_F(MapBundleFiles, AreRefusedWhenMapYamlIsCutAnywhere) {
  const std::string yaml = content_of(map() / "map.yaml");
  for (std::size_t size = 0; size < yaml.size(); size += 3) {
    put(map() / "map.yaml", yaml.substr(0, size));
    EXPECT_FALSE(read_map_bundle(map()).has_value()) << size;
  }
}

TEST_F(MapBundleFiles, AreRefusedWhenMapYamlIsAltered) {
  std::string yaml = content_of(map() / "map.yaml");
  yaml.replace(yaml.find("seed: 9"), 7, "seed: 8");
  put(map() / "map.yaml", yaml);
  expect_refused("map.yaml");
}

TEST_F(MapBundleFiles, AreRefusedWhenMapYamlIsHuge) {
  put(map() / "map.yaml", std::string(2'000'000, '#'));
  expect_refused("map.yaml");
}

TEST(MapBundle, IsRecognisedByItsMapYaml) {
  const TemporaryFolder temporary;
  EXPECT_FALSE(is_map_bundle(temporary.path()));
  ASSERT_TRUE(write_map_bundle({}, temporary / "map").has_value());
  EXPECT_TRUE(is_map_bundle(temporary / "map"));
}

TEST(MapBundle, OfARunWithoutAModuleHoldsNoneOfItsMaps) {
  const TemporaryFolder temporary;
  ASSERT_TRUE(write_map_bundle({}, temporary / "map").has_value());
  const auto bundle = read_map_bundle(temporary / "map");
  ASSERT_TRUE(bundle.has_value()) << bundle.error().message;
  EXPECT_FALSE(bundle->grid.has_value());
  EXPECT_TRUE(bundle->landmarks.empty());
}

TEST(MapBundle, ThatCannotBeWrittenLeavesNothing) {
  const TemporaryFolder temporary;
  put(temporary / "file", "x");
  EXPECT_FALSE(write_map_bundle(small_bundle(), temporary / "file/map").has_value());
  EXPECT_THAT(names_in(temporary.path()), ElementsAre("file"));
}

}  // namespace
}  // namespace slamfuse::service
