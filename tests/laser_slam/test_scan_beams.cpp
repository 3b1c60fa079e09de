// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/scan_beams.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

using ::testing::HasSubstr;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

common::LaserCalibration quarter_laser() {
  common::LaserCalibration laser;
  laser.angle_min = 0.0;
  laser.angle_increment = std::numbers::pi / 2.0;
  laser.beams = 4;
  laser.range_min = 0.1;
  laser.range_max = 10.0;
  return laser;
}

common::LaserScan scan_of(std::vector<float> ranges) { return {0, "laser0", std::move(ranges)}; }

TEST(ProjectScan, PutsTheMountingBetweenRangeAndBase) {
  common::LaserCalibration laser = quarter_laser();
  laser.T_base_laser = common::to_pose3({0.5, 0.1, std::numbers::pi / 2.0});
  const auto beams = project_scan(scan_of({2.0f, 1.0f, 1.0f, 1.0f}), laser, {}, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  EXPECT_NEAR((beams->beams[0].end - Eigen::Vector2d(0.5, 2.1)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((beams->beams[0].origin - Eigen::Vector2d(0.5, 0.1)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((beams->beams[1].end - Eigen::Vector2d(-0.5, 0.1)).norm(), 0.0, 1e-9);
}

TEST(ProjectScan, MirrorsALaserThatHangsUpsideDown) {
  common::LaserCalibration laser = quarter_laser();
  laser.T_base_laser.rotation = Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX());
  const auto beams = project_scan(scan_of({1.0f, 2.0f, 3.0f, 4.0f}), laser, {}, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  EXPECT_NEAR((beams->beams[0].end - Eigen::Vector2d(1.0, 0.0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((beams->beams[1].end - Eigen::Vector2d(0.0, -2.0)).norm(), 0.0, 1e-6);
}

TEST(ProjectScan, UndoesTheMotionDuringTheSweep) {
  const auto walls = testing::room();
  common::LaserCalibration laser = testing::full_circle_laser(360);
  laser.sweep_duration = 0.1;
  const Eigen::Vector3d twist(1.0, 0.0, 1.5);
  const common::LaserScan moving =
      testing::scan_at(walls, laser, 0, [&](double seconds) { return common::exp_se2(twist * seconds); });
  const auto compensated = project_scan(moving, laser, {}, twist);
  const auto raw = project_scan(moving, laser, {}, Eigen::Vector3d::Zero());
  ASSERT_TRUE(compensated && raw);
  double worst = 0.0, worst_raw = 0.0;
  const auto off_the_walls = [&](const Beam& beam) {
    const Eigen::Vector2d ray = beam.end - beam.origin;
    return std::abs(testing::cast(walls, beam.origin, std::atan2(ray.y(), ray.x())) - ray.norm());
  };
  for (const Beam& beam : compensated->beams) worst = std::max(worst, off_the_walls(beam));
  for (const Beam& beam : raw->beams) worst_raw = std::max(worst_raw, off_the_walls(beam));
  EXPECT_LT(worst, 1e-4);
  EXPECT_GT(worst_raw, 0.1);
}

TEST(ProjectScan, FollowsTheRosConventionsForBeamsWithoutMeasurement) {
  BeamLimits limits;
  limits.free_beyond_range = 3.0;
  const auto beams =
      project_scan(scan_of({kInf, kNan, -kInf, 0.05f}), quarter_laser(), limits, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  ASSERT_EQ(beams->beams.size(), 1u) << "only +inf tells something: that the way is free";
  EXPECT_FALSE(beams->beams[0].hit);
  EXPECT_NEAR(beams->beams[0].end.x(), 3.0, 1e-9);
  EXPECT_TRUE(beams->match_points.empty());
}

TEST(ProjectScan, TakesRangesFromTheMaximumUpAsNothingSeen) {
  BeamLimits limits;
  limits.max_range = 5.0;
  const auto beams =
      project_scan(scan_of({10.0f, 7.0f, 4.9f, 12.0f}), quarter_laser(), limits, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  EXPECT_EQ(beams->match_points.size(), 1u);
}

TEST(ProjectScan, RejectsImpossibleScansWithTheReason) {
  const auto reason = [](std::vector<float> ranges) {
    const auto beams = project_scan(scan_of(std::move(ranges)), quarter_laser(), {}, Eigen::Vector3d::Zero());
    return beams ? std::string() : beams.error().message;
  };
  EXPECT_THAT(reason({1.0f, 1.0f, 1.0f}), HasSubstr("3 ranges, allowed are 4"));
  EXPECT_THAT(reason({}), HasSubstr("0 ranges"));
  EXPECT_THAT(reason({1.0f, -2.0f, 1.0f, 1.0f}), HasSubstr("range -2 of beam 1"));
  EXPECT_THAT(reason({kNan, kNan, kNan, kNan}), HasSubstr("no usable beam"));
}

TEST(ProjectScan, TakesAnyFieldOfViewAndAnyNumberOfBeamsFromTwo) {
  for (const int beams : {2, 45, 684, 10000}) {
    for (const double degrees : {1.0, 90.0, -270.0, 360.0}) {
      common::LaserCalibration laser = testing::full_circle_laser(beams);
      laser.angle_min = -common::to_radians(degrees / 2.0);
      laser.angle_increment = common::to_radians(degrees) / (beams - 1);
      const auto walls = testing::room();
      const auto scan = testing::scan_at(walls, laser, 0, common::Pose2{});
      const auto projected = project_scan(scan, laser, {}, Eigen::Vector3d::Zero());
      ASSERT_TRUE(projected) << beams << " beams over " << degrees << " deg: " << projected.error().message;
      ASSERT_EQ(projected->beams.size(), static_cast<std::size_t>(beams));
      EXPECT_LE(projected->match_points.size(), 360u);
      for (const std::size_t i : {std::size_t{0}, projected->beams.size() / 3, projected->beams.size() - 1}) {
        const double bearing = laser.angle_min + static_cast<double>(i) * laser.angle_increment;
        const Eigen::Vector2d expected =
            testing::cast(walls, {0.0, 0.0}, bearing) * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
        EXPECT_LT((projected->beams[i].end - expected).norm(), 1e-5) << beams << " beams over " << degrees << " deg";
      }
    }
  }
}

TEST(ProjectScan, TakesScansWhoseNumberOfBeamsChangesWhereItMay) {
  common::LaserCalibration laser = quarter_laser();
  laser.beams = 0;
  for (const std::size_t count : {std::size_t{2}, std::size_t{7}, std::size_t{3}}) {
    const auto beams = project_scan(scan_of(std::vector<float>(count, 1.0f)), laser, {}, Eigen::Vector3d::Zero());
    ASSERT_TRUE(beams);
    EXPECT_EQ(beams->beams.size(), count);
  }
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}}) {
    const auto beams = project_scan(scan_of(std::vector<float>(count, 1.0f)), laser, {}, Eigen::Vector3d::Zero());
    ASSERT_FALSE(beams);
    EXPECT_THAT(beams.error().message, HasSubstr("allowed are 2 or more"));
  }
}

TEST(ProjectScan, KeepsTheBearingsOfBeamsBesideOnesWithoutMeasurement) {
  const auto beams = project_scan(scan_of({kNan, 1.0f, kNan, 2.0f}), quarter_laser(), {}, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  ASSERT_EQ(beams->match_points.size(), 2u);
  EXPECT_LT((beams->match_points[0] - Eigen::Vector2d(0.0, 1.0)).norm(), 1e-9);
  EXPECT_LT((beams->match_points[1] - Eigen::Vector2d(0.0, -2.0)).norm(), 1e-9);
}

TEST(ProjectScan, TakesAScanThatSawNothingAtAll) {
  const auto beams = project_scan(scan_of({kInf, kInf, kInf, kInf}), quarter_laser(), {}, Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  EXPECT_EQ(beams->beams.size(), 4u);
  EXPECT_TRUE(beams->match_points.empty());
}

TEST(ProjectScan, ThinsTheHitsEvenly) {
  common::LaserCalibration laser = testing::full_circle_laser(1000);
  BeamLimits limits;
  limits.max_match_points = 100;
  const auto beams = project_scan(testing::scan_at(testing::room(), laser, 0, common::Pose2{}), laser, limits,
                                  Eigen::Vector3d::Zero());
  ASSERT_TRUE(beams);
  EXPECT_EQ(beams->match_points.size(), 100u);
  EXPECT_EQ(beams->beams.size(), 1000u);
}

TEST(CheckCalibration, NamesWhatCannotBeUsed) {
  const auto reason = [](auto change) {
    common::LaserCalibration laser = quarter_laser();
    change(laser);
    const auto checked = check_calibration("laser0", laser);
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_EQ(reason([](auto&) {}), "");
  EXPECT_THAT(reason([](auto& laser) { laser.angle_increment = 0.0; }), HasSubstr("angle_increment"));
  EXPECT_THAT(reason([](auto& laser) { laser.angle_increment = 1e300; }), HasSubstr("angle_increment is 1e+300"));
  EXPECT_THAT(reason([](auto& laser) { laser.angle_min = -1e300; }), HasSubstr("angle_min is -1e+300"));
  EXPECT_THAT(reason([](auto& laser) { laser.range_max = 0.05; }), HasSubstr("range_min"));
  EXPECT_THAT(reason([](auto& laser) { laser.range_max = laser.range_min; }), HasSubstr("range_min < range_max"));
  EXPECT_THAT(reason([](auto& laser) { laser.beams = -1; }), HasSubstr("beams"));
  EXPECT_THAT(reason([](auto& laser) { laser.sweep_duration = -1.0; }), HasSubstr("sweep_duration"));
  EXPECT_THAT(reason([](auto& laser) { laser.sweep_duration = 1e300; }), HasSubstr("0 (unknown) to 60 s"));
  EXPECT_THAT(
      reason([](auto& laser) { laser.T_base_laser.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()); }),
      HasSubstr("tilted"));
}

}  // namespace
}  // namespace slamfuse::laser_slam
