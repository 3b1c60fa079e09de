// SPDX-License-Identifier: BSD-3-Clause
// Bad messages in a good recording: dropped, counted, told, and the run goes on (DESIGN section 2).
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class BadMessages : public testing::Test {
 protected:
  void SetUp() override { copy_beginning_of_flat(scratch_ / "flat", 3.0); }

  fs::path recording() const { return scratch_ / "flat"; }

  /// The file of the n-th image of a camera.
  fs::path image(const std::string& camera, std::size_t n) const {
    const std::string line = read_lines(recording() / camera / "data.csv").at(n);
    return recording() / camera / "data" / line.substr(line.find(',') + 1);
  }

  void edit_lines(const std::string& csv, const std::function<void(std::vector<std::string>&)>& edit) const {
    auto lines = read_lines(recording() / csv);
    edit(lines);
    write_lines(recording() / csv, lines);
  }

  /// Runs and expects that the module went on after rejecting this many, with an event that contains the words.
  void expect_rejected(const std::string& module, int rejected, const std::vector<std::string>& words) const {
    const Outcome outcome = run_program({"run", recording().string(), "-o", (scratch_ / "out").string()});
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    const auto metrics = read_json(scratch_ / "out/metrics.json");
    EXPECT_EQ(metrics["modules"][module]["rejected"], rejected) << metrics["events"].dump(1);
    EXPECT_GT(metrics["modules"][module]["poses"], 0);
    std::string told;
    for (const auto& event : metrics["events"]) {
      if (event["kind"] == "rejected") told += event["detail"].get<std::string>() + "\n";
    }
    for (const auto& word : words) EXPECT_THAT(told, HasSubstr(word));
  }

  Scratch scratch_;
};

TEST_F(BadMessages, CutImage) {
  const fs::path path = image("cam0", 5);
  write_text(path, read_text(path).substr(0, 2000));
  expect_rejected("visual", 1, {"cam0", path.filename().string()});
}

TEST_F(BadMessages, GarbledAndMissingImages) {
  write_text(image("cam0", 4), "this is no picture");
  fs::remove(image("cam1", 6));
  expect_rejected("visual", 2, {"cam0", "cam1"});
}

TEST_F(BadMessages, ImageOfTheWrongSize) {
  // A PGM of 2x2 pixels under the name of a JPEG: pictures are recognised by content.
  write_text(image("cam0", 5), "P5\n2 2\n255\nabcd");
  expect_rejected("visual", 1, {"cam0", "640"});
}

TEST_F(BadMessages, ScanWithTooFewRanges) {
  edit_lines("laser0/data.csv", [](auto& lines) { lines[5].erase(lines[5].rfind(',', 200)); });
  expect_rejected("laser", 1, {"laser0", "684"});
}

TEST_F(BadMessages, ScanWithANegativeRange) {
  edit_lines("laser0/data.csv", [](auto& lines) { lines[5].replace(lines[5].find(',') + 1, 5, "-1.23"); });
  expect_rejected("laser", 1, {"laser0", "-1.23"});
}

TEST_F(BadMessages, ScanWithInfiniteAndUnmeasuredRangesIsUsed) {
  edit_lines("laser0/data.csv", [](auto& lines) {
    lines[5].replace(lines[5].find(',') + 1, 5, "nan");
    lines[6].replace(lines[6].find(',') + 1, 5, "inf");
  });
  const Outcome outcome = run_program({"run", recording().string(), "-o", (scratch_ / "out").string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  const auto laser = read_json(scratch_ / "out/metrics.json")["modules"]["laser"];
  EXPECT_EQ(laser["poses"].get<int>() + laser["rejected"].get<int>(), laser["inputs"].get<int>());
  EXPECT_LE(laser["rejected"], 2);
}

TEST_F(BadMessages, RepeatedStamps) {
  edit_lines("laser0/data.csv", [](auto& lines) { lines.insert(lines.begin() + 6, lines[5]); });
  edit_lines("odom0/data.csv", [](auto& lines) { lines.insert(lines.begin() + 9, lines[8]); });
  expect_rejected("laser", 1, {"laser0", "odom0"});
  EXPECT_EQ(read_json(scratch_ / "out/metrics.json")["modules"]["fusion"]["rejected"], 1);
}

TEST_F(BadMessages, StampsThatStepBack) {
  edit_lines("laser0/data.csv", [](auto& lines) { lines.insert(lines.begin() + 9, lines[3]); });
  expect_rejected("laser", 1, {"laser0"});
}

TEST_F(BadMessages, EveryImageBrokenLeavesTheLaserToGoOn) {
  for (const auto& camera : {"cam0", "cam1"}) {
    for (const auto& entry : fs::directory_iterator(recording() / camera / "data")) write_text(entry.path(), "broken");
  }
  const Outcome outcome = run_program({"run", recording().string(), "-o", (scratch_ / "out").string()});
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  const auto metrics = read_json(scratch_ / "out/metrics.json");
  EXPECT_EQ(metrics["modules"]["visual"]["rejected"], 30);
  EXPECT_EQ(metrics["modules"]["visual"]["poses"], 0);
  EXPECT_GT(metrics["modules"]["fusion"]["poses"], 0);
  EXPECT_LT(metrics["events"].size(), 20U) << "thirty broken images must not flood the report";
}

}  // namespace
}  // namespace slamfuse::system
