// SPDX-License-Identifier: BSD-3-Clause
#include "common/relations.hpp"

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/carmen_reference.hpp"
#include "common/temporary_file.hpp"

namespace slamfuse::common {
namespace {

using testing::HasSubstr;

constexpr Nanoseconds kSecond = kNanosecondsPerSecond;

TEST(ReadRelations, ReadsStampsDigitByDigit) {
  const TemporaryFile file("intel.relations",
                           "976052905.167303 976052911.885496 -0.056990 -0.128430 0.0 0.0 0.0 -1.682210\n");

  const auto relations = read_relations(file.path());

  ASSERT_TRUE(relations.has_value()) << relations.error().message;
  ASSERT_EQ(relations->size(), 1u);
  EXPECT_EQ(relations->front().from, 976052905167303000);
  EXPECT_EQ(relations->front().to, 976052911885496000);
  EXPECT_EQ(relations->front().T_from_to.vector(), Eigen::Vector3d(-0.056990, -0.128430, -1.682210));
}

TEST(ReadRelations, RefusesBrokenLinesWithTheirPlace) {
  const auto message = [](const std::string& text) {
    return read_relations(TemporaryFile("r.relations", text).path()).error().message;
  };
  EXPECT_THAT(message(""), HasSubstr("has no line of numbers"));
  EXPECT_THAT(message("1 2 3\n"), HasSubstr("r.relations:1: 3 columns, expected 8"));
  EXPECT_THAT(message("1 2 0 0 0 0 0 0\n1 2 0 inf 0 0 0 0\n"), HasSubstr("r.relations:2: column 4 is 'inf'"));
  EXPECT_THAT(message("1 2 0 0 0.1 0 0 0\n"), HasSubstr("z 0.1, roll 0, pitch 0: expected 0"));
}

TEST(EvaluateRelations, IsZeroForATrueTrajectoryInAnyFrame) {
  const Pose2 a{1, 2, 3};
  const Pose2 motion{0.5, -0.25, 1.0};
  const Pose2 frame{-40, 7, -2};

  const auto accuracy = evaluate_relations({{1 * kSecond, frame * a}, {2 * kSecond, frame * a * motion}},
                                           {{1 * kSecond, 2 * kSecond, motion}});

  ASSERT_TRUE(accuracy.has_value()) << accuracy.error().message;
  EXPECT_EQ(accuracy->all.matched, 1u);
  EXPECT_NEAR(accuracy->all.translation_m.mean, 0.0, 1e-12);
  EXPECT_NEAR(accuracy->all.rotation_deg.mean, 0.0, 1e-10);
}

TEST(EvaluateRelations, AveragesAbsoluteAndSquaredErrors) {
  const Trajectory2 trajectory = {{0, {}}, {1 * kSecond, {1, 0, 0}}, {100 * kSecond, {0, 2, to_radians(10)}}};

  const auto accuracy = evaluate_relations(
      trajectory, {{0, 1 * kSecond, {1.1, 0, 0}}, {0, 100 * kSecond, {0, 2.3, to_radians(-20)}}, {0, 7 * kSecond, {}}});

  ASSERT_TRUE(accuracy.has_value()) << accuracy.error().message;
  EXPECT_EQ(accuracy->all.matched, 2u);
  EXPECT_EQ(accuracy->missing, 1u);
  EXPECT_NEAR(accuracy->all.translation_m.mean, 0.2, 1e-12);
  EXPECT_NEAR(accuracy->all.translation_m.deviation, 0.1, 1e-12);
  EXPECT_NEAR(accuracy->all.translation_squared_m2.mean, (0.01 + 0.09) / 2, 1e-12);
  EXPECT_NEAR(accuracy->all.translation_squared_m2.deviation, 0.04, 1e-12);
  EXPECT_NEAR(accuracy->all.rotation_deg.mean, 15.0, 1e-10);
  EXPECT_NEAR(accuracy->all.rotation_squared_deg2.mean, 450.0, 1e-9);
  EXPECT_EQ(accuracy->distant.matched, 1u);
  EXPECT_NEAR(accuracy->distant.translation_m.mean, 0.3, 1e-12);
  EXPECT_NEAR(accuracy->distant.rotation_deg.mean, 30.0, 1e-10);
}

TEST(EvaluateRelations, CountsRelationsBackInTimeAsDistantToo) {
  const auto accuracy =
      evaluate_relations({{0, {}}, {61 * kSecond, {}}}, {{61 * kSecond, 0, {}}, {0, 60 * kSecond, {}}});

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_EQ(accuracy->distant.matched, 1u);
}

TEST(EvaluateRelations, TakesTheFirstOfSeveralPosesWithOneStamp) {
  const auto accuracy = evaluate_relations({{0, {}}, {kSecond, {1, 0, 0}}, {kSecond, {9, 0, 0}}, {0, {5, 0, 0}}},
                                           {{0, kSecond, {1, 0, 0}}});

  ASSERT_TRUE(accuracy.has_value());
  EXPECT_EQ(accuracy->all.translation_m.mean, 0.0);
}

TEST(EvaluateRelations, MatchesStampsToTheNanosecond) {
  const auto accuracy = evaluate_relations({{0, {}}, {kSecond + 1, {}}}, {{0, kSecond, {}}});

  ASSERT_FALSE(accuracy.has_value());
  EXPECT_EQ(accuracy.error().kind, ErrorKind::kInvalidInput);
  EXPECT_THAT(accuracy.error().message, HasSubstr("none of the 1 relations"));
}

/// The corrected log that comes with the Freiburg building 79 recording must score like the published methods on it:
/// 0.045 m (Cartographer) to 0.061 m (Rao-Blackwellised filter), and better as base poses, which the relations are
/// between, than as laser poses.
TEST(EvaluateRelations, ScoresACorrectedLogOfFreiburg79LikeThePublishedMethods) {
  const char* recordings = std::getenv("SLAMFUSE_RECORDINGS");
  if (recordings == nullptr) GTEST_SKIP() << "SLAMFUSE_RECORDINGS is not set, real recordings are not at hand";
  const std::filesystem::path folder = std::filesystem::path(recordings) / "real" / "radish";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " does not exist";
  const Pose2 T_base_laser{-0.04, 0.0, 0.0};  // laser pose against odometry pose in the log's FLASER lines

  const auto laser = read_carmen_reference(folder / "fr079.reference.txt");
  const auto relations = read_relations(folder / "fr079.relations");
  ASSERT_TRUE(laser.has_value() && relations.has_value());
  const auto of_laser = evaluate_relations(*laser, *relations);
  const auto of_base = evaluate_relations(sensor_trajectory(*laser, T_base_laser.inverse()), *relations);

  ASSERT_TRUE(of_laser.has_value() && of_base.has_value());
  EXPECT_EQ(of_base->all.matched, 1672u);
  EXPECT_EQ(of_base->missing, 13u);
  EXPECT_NEAR(of_base->all.translation_m.mean, 0.0456, 0.0001);
  EXPECT_NEAR(of_base->all.translation_m.deviation, 0.0318, 0.0001);
  EXPECT_NEAR(of_base->all.rotation_deg.mean, 0.70, 0.01);
  EXPECT_NEAR(of_laser->all.translation_m.mean, 0.0582, 0.0001);
}

}  // namespace
}  // namespace slamfuse::common
