// SPDX-License-Identifier: BSD-3-Clause
#include "common/config.hpp"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/temporary_file.hpp"

namespace slamfuse::common {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

enum class Motion { kSlow, kFast };

struct GridOptions {
  double resolution = 0.05;
  bool publish = true;
  void describe(OptionVisitor& visit) {
    visit.real("resolution", resolution, {0.005, 1.0}, "m", "Side of a map cell.");
    visit.flag("publish", publish, "Whether the map is published | told.");
  }
};

struct LaserOptions {
  int particles = 30;
  double threshold = 1.0 / 3.0;
  Motion motion = Motion::kSlow;
  GridOptions grid;
  void describe(OptionVisitor& visit) {
    visit.integer("particles", particles, {1, 1000}, "", "Number of particles.");
    visit.real("threshold", threshold, {0.0, std::numeric_limits<double>::infinity()}, "rad", "When to resample.");
    visit.choice("motion", motion, {{"slow", Motion::kSlow}, {"fast", Motion::kFast}}, "How the robot moves.");
    visit.nested("grid", grid, "The map.");
  }
};

struct Options {
  LaserOptions laser;
  int seed = 1;
  void describe(OptionVisitor& visit) {
    visit.integer("seed", seed, {0, std::numeric_limits<int>::max()}, "", "Of all random numbers.");
    visit.nested("laser", laser, "The laser half.");
  }
};

DescribeOptions describer(Options& options) {
  return [&options](OptionVisitor& visit) { options.describe(visit); };
}

std::string as_text(Options options) { return options_to_yaml(describer(options)); }

Result<void> read_text(const std::string& yaml, Options& options) {
  return read_options(TemporaryFile("robot.yaml", yaml).path(), describer(options));
}

TEST(ReadOptions, ChangesOnlyTheKeysThatAreGiven) {
  Options options;

  const Result<void> read = read_text(
      "# comment\nseed: 7\nlaser:\n  particles: 100\n  motion: fast\n  grid: {resolution: 1e-2, publish: false}\n",
      options);

  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(options.seed, 7);
  EXPECT_EQ(options.laser.particles, 100);
  EXPECT_EQ(options.laser.motion, Motion::kFast);
  EXPECT_EQ(options.laser.grid.resolution, 0.01);
  EXPECT_FALSE(options.laser.grid.publish);
  EXPECT_EQ(options.laser.threshold, 1.0 / 3.0);
}

struct FolderOptions {
  std::string folder;
  void describe(OptionVisitor& visit) { visit.text("folder", folder, "Where the pictures are."); }
};

TEST(ReadOptions, TakesAnyTextAndPrintsWhatItReadsBack) {
  for (const std::string text : {"", "plain/path", "17", "with \"quotes\" and \\ and # and: colon"}) {
    FolderOptions written, read;
    written.folder = text;
    const std::string yaml = options_to_yaml([&](OptionVisitor& visit) { written.describe(visit); });

    const TemporaryFile file("robot.yaml", yaml);
    ASSERT_TRUE(read_options(file.path(), [&](OptionVisitor& visit) { read.describe(visit); }).has_value()) << yaml;
    EXPECT_EQ(read.folder, text);
    ASSERT_TRUE(set_option("folder=" + text, [&](OptionVisitor& visit) { written.describe(visit); }).has_value());
    EXPECT_EQ(written.folder, text);
  }
}

TEST(ReadOptions, RefusesTextThatIsAListOrEmptyOrOfTwoLines) {
  for (const char* yaml : {"folder: [a, b]\n", "folder:\n", "folder: \"a\\nb\"\n"}) {
    FolderOptions options;
    const TemporaryFile file("robot.yaml", yaml);
    const auto read = read_options(file.path(), [&](OptionVisitor& visit) { options.describe(visit); });
    ASSERT_FALSE(read.has_value()) << yaml;
    EXPECT_THAT(read.error().message, AllOf(HasSubstr("folder"), HasSubstr("text on one line")));
  }
}

TEST(ReadOptions, AcceptsBothEndsOfARange) {
  Options options;
  EXPECT_TRUE(read_text("laser: {particles: 1, grid: {resolution: 1}}\n", options).has_value());
  EXPECT_TRUE(read_text("laser: {particles: 1000, grid: {resolution: 0.005}}\n", options).has_value());
}

struct BadYaml {
  const char* name;
  std::string yaml;
  std::string message;
};

std::ostream& operator<<(std::ostream& out, const BadYaml& bad) { return out << bad.name; }

class ReadOptionsRefuses : public testing::TestWithParam<BadYaml> {};

TEST_P(ReadOptionsRefuses, WithPlaceKeyAndValueAndLeavesTheOptionsAlone) {
  Options options;
  const std::string before = as_text(options);

  const Result<void> read = read_text(GetParam().yaml, options);

  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(read.error().message, AllOf(HasSubstr("robot.yaml"), HasSubstr(GetParam().message)));
  EXPECT_EQ(as_text(options), before);
}

std::string nested(int levels) {
  std::string yaml;
  for (int i = 0; i < levels; ++i) yaml += "{a: ";
  return yaml + std::string(static_cast<std::size_t>(levels), '}');
}

INSTANTIATE_TEST_SUITE_P(
    Files, ReadOptionsRefuses,
    testing::Values(
        BadYaml{"Empty", "", "is empty"}, BadYaml{"OnlyComments", "# nothing\n", "is empty"},
        BadYaml{"Scalar", "hello\n", "robot.yaml:1:1: expected `key: value` pairs"},
        BadYaml{"List", "- seed\n", "robot.yaml:1:1: expected `key: value` pairs"},
        BadYaml{"UnknownKey", "seed: 3\nlaser:\n  partciles: 5\n",
                "robot.yaml:3:3: unknown key 'laser.partciles', allowed here: particles, "},
        BadYaml{"UnknownSection", "lasr: {}\n", "robot.yaml:1:1: unknown key 'lasr', allowed here: laser, seed"},
        BadYaml{"DuplicateKey", "seed: 3\nseed: 4\n", "robot.yaml:2:1: the key 'seed' is given twice, first at "},
        BadYaml{"DuplicateSection", "laser: {}\nlaser: {}\n", "'laser' is given twice"},
        BadYaml{"WordForNumber", "laser:\n  particles: many\n",
                "robot.yaml:2:14: laser.particles is 'many', expected a whole number, 1 to 1000"},
        BadYaml{"RealForInteger", "seed: 3.5\n", "seed is '3.5', expected a whole number, at least 0"},
        BadYaml{"IntegerTooLong", "seed: 99999999999\n", "seed is '99999999999'"},
        BadYaml{"NumberInQuotes", "seed: \"3\"\n", "seed is '3', expected a whole number"},
        BadYaml{"OutOfRange", "laser: {grid: {resolution: 2}}\n",
                "laser.grid.resolution is '2', expected a number, 0.005 to 1.0 m"},
        BadYaml{"NotANumber", "laser: {threshold: .nan}\n", "laser.threshold is '.nan'"},
        BadYaml{"PlainNan", "laser: {threshold: nan}\n", "laser.threshold is 'nan'"},
        BadYaml{"Infinity", "laser: {threshold: inf}\n", "expected a number, at least 0.0 rad"},
        BadYaml{"YesForFlag", "laser: {grid: {publish: yes}}\n", "publish is 'yes', expected true or false"},
        BadYaml{"UnknownWord", "laser: {motion: fats}\n", "laser.motion is 'fats', expected one of fast, slow"},
        BadYaml{"NothingForNumber", "seed:\n", "seed is empty"},
        BadYaml{"NothingForSection", "laser:\n", "laser is empty, expected a group of keys"},
        BadYaml{"ListForNumber", "seed: [1, 2]\n", "seed is a list"},
        BadYaml{"MapForNumber", "seed: {a: 1}\n", "seed is a group of keys"},
        BadYaml{"NumberForSection", "laser: 3\n", "laser is '3', expected a group of keys"},
        BadYaml{"ListAsKey", "[a]: 3\n", "expected a word as key"},
        BadYaml{"TwoDocuments", "seed: 3\n---\nseed: 4\n", "a second document starts here"},
        BadYaml{"Anchor", "laser: &l {particles: 3}\n", "anchors and aliases are not supported"},
        BadYaml{"Tag", "seed: !!int 3\n", "is not supported"},
        BadYaml{"TabIndent", "laser:\n\tparticles: 3\n", "robot.yaml:2:"},
        BadYaml{"BrokenYaml", "laser: {particles: 3\n", "robot.yaml:2:1"},
        BadYaml{"WrongIndent", "laser:\n    particles: 3\n  motion: fast\n", "robot.yaml:3:"},
        BadYaml{"TooDeep", nested(40), "nested deeper than 16 levels"},
        BadYaml{"FarTooDeep", std::string(100000, '['), "robot.yaml"},
        BadYaml{"TooLarge", "seed: 3\n#" + std::string(std::size_t{300} * 1024, 'x'), "larger than 262144 bytes"},
        BadYaml{"Binary",
                std::string("\x7f"
                            "ELF\0\1\2\xff\n",
                            9),
                "robot.yaml:1:"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(ReadOptions, TellsAllMistakesAtOnce) {
  Options options;

  const Result<void> read = read_text("seed: -1\nlaser:\n  particles: 0\n  spede: 3\n", options);

  ASSERT_FALSE(read.has_value());
  EXPECT_THAT(read.error().message, AllOf(HasSubstr("seed is '-1'"), HasSubstr("\n"),
                                          HasSubstr("laser.particles is '0'"), HasSubstr("'laser.spede'")));
}

TEST(ReadOptions, RefusesMissingFilesAndFolders) {
  Options options;
  EXPECT_THAT(read_options("/no/such.yaml", describer(options)).error().message,
              HasSubstr("/no/such.yaml: cannot be opened: No such file"));
  EXPECT_THAT(read_options("/", describer(options)).error().message, HasSubstr("is a folder"));
}

TEST(SetOption, SetsOneDottedKey) {
  Options options;

  ASSERT_TRUE(set_option("laser.grid.resolution=0.1", describer(options)).has_value());
  ASSERT_TRUE(set_option("laser.motion=fast", describer(options)).has_value());

  EXPECT_EQ(options.laser.grid.resolution, 0.1);
  EXPECT_EQ(options.laser.motion, Motion::kFast);
  EXPECT_EQ(options.laser.particles, 30);
}

TEST(SetOption, RefusesAsWrongUsage) {
  Options options;
  const std::string before = as_text(options);
  for (const auto& [text, message] :
       std::vector<std::pair<std::string, std::string>>{{"laser.particles", "expected key=value"},
                                                        {"=3", "a part of the key is empty"},
                                                        {"laser..particles=3", "a part of the key is empty"},
                                                        {"laser.particles=", "laser.particles is ''"},
                                                        {"laser.particles=1001", "1 to 1000"},
                                                        {"laser.particle=3", "allowed here: particles"},
                                                        {"laser=3", "expected a group of keys"},
                                                        {"seed.x=3", "seed is a group of keys"},
                                                        {std::string(100, '.') + "=3", "more than 16 parts"}}) {
    const Result<void> set = set_option(text, describer(options));
    ASSERT_FALSE(set.has_value()) << text;
    EXPECT_EQ(set.error().kind, ErrorKind::kUsage) << text;
    EXPECT_THAT(set.error().message, HasSubstr(message));
  }
  EXPECT_EQ(as_text(options), before);
}

TEST(OptionsToYaml, ReadsBackToExactlyTheSameValues) {
  Options written;
  written.laser.threshold = 0.1 + 0.2;
  written.laser.grid.resolution = 0.0051;
  written.laser.motion = Motion::kFast;
  written.seed = 12345;

  Options read;
  const Result<void> result = read_text(as_text(written), read);

  ASSERT_TRUE(result.has_value()) << result.error().message;
  EXPECT_EQ(as_text(read), as_text(written));
  EXPECT_EQ(read.laser.threshold, 0.1 + 0.2);
}

TEST(OptionsToYaml, AnnotatesEveryKey) {
  EXPECT_THAT(as_text({}), HasSubstr("  # The map.\n  grid:\n    # Side of a map cell. (0.005 to 1.0 m)\n"
                                     "    resolution: 0.05\n"));
}

TEST(OptionsToMarkdown, HasARowForEveryOption) {
  Options options;
  EXPECT_THAT(options_to_markdown(describer(options)),
              AllOf(HasSubstr("| `laser.motion` | slow | slow, fast | How the robot moves. |\n"),
                    HasSubstr("published \\| told"), Not(HasSubstr("The laser half"))));
}

TEST(OptionsToHelp, HasALineForEveryOption) {
  Options options;
  EXPECT_THAT(options_to_help(describer(options)),
              HasSubstr("  laser.particles=30\n      Number of particles. (1 to 1000)\n"));
}

}  // namespace
}  // namespace slamfuse::common
