// SPDX-License-Identifier: BSD-3-Clause
#include "service/structure_picture.hpp"

#include <cmath>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/markup_checks.hpp"

namespace slamfuse::service {
namespace {

using testing::HasSubstr;
using testing::Not;

StructureAndMotion wall_seen_from_a_path(int landmarks) {
  StructureAndMotion map;
  for (int i = 0; i < landmarks; ++i) {
    common::Landmark landmark;
    landmark.position = {0.04 * i, 3.0, 0.01 * (i % 100)};
    landmark.covariance = Eigen::Vector3d(0.01, 0.04, 0.0025).asDiagonal();
    map.landmarks.push_back(landmark);
  }
  for (int i = 0; i < 5; ++i) {
    common::Keyframe keyframe;
    keyframe.T_map_camera.translation = {1.0 * i, 0.0, 0.7};
    map.keyframes.push_back(keyframe);
    map.path.push_back({i, {1.0 * i, 0.0, 0.0}});
  }
  return map;
}

TEST(StructurePicture, ShowsPathCamerasAndLandmarksFromAboveAndFromTheSide) {
  for (const ViewPoint from : {ViewPoint::kAbove, ViewPoint::kSide}) {
    const std::string svg = structure_picture(wall_seen_from_a_path(100), from);

    EXPECT_EQ(nesting_fault(svg), "");
    EXPECT_EQ(occurrences(svg, "<ellipse"), 100U);
    for (const char* part : {"class=\"camera\"", "class=\"line visual\"", "dots points landmark", "2 sigma", "x [m]"}) {
      EXPECT_THAT(svg, HasSubstr(part));
    }
    EXPECT_THAT(svg, HasSubstr(from == ViewPoint::kAbove ? "y [m]" : "z [m]"));
  }
}

TEST(StructurePicture, LooksAtTheLongerSide) {
  StructureAndMotion map = wall_seen_from_a_path(100);
  for (auto& landmark : map.landmarks) std::swap(landmark.position.x(), landmark.position.y());
  for (auto& keyframe : map.keyframes) keyframe.T_map_camera.translation.head<2>().reverseInPlace();
  for (auto& stamped : map.path) std::swap(stamped.pose.x, stamped.pose.y);

  const std::string svg = structure_picture(map, ViewPoint::kSide);

  EXPECT_THAT(svg, HasSubstr("y [m]"));
  EXPECT_THAT(svg, Not(HasSubstr("x [m]")));
}

TEST(StructurePicture, DrawsEllipsesByTheCovarianceInItsPlane) {
  StructureAndMotion map;
  for (const double x : {0.0, 10.0}) {
    common::Landmark landmark;
    landmark.position = {x, 0.0, 0.0};
    // Half axes of 1 m along the diagonal of x and y, and 0.5 m across it, at two sigma.
    landmark.covariance << 0.15625, 0.09375, 0.0, 0.09375, 0.15625, 0.0, 0.0, 0.0, 4.0;
    map.landmarks.push_back(landmark);
  }

  const std::string svg = structure_picture(map, ViewPoint::kAbove);

  // 540 units for 10 m and a border of 5 % on either side.
  EXPECT_THAT(svg, testing::AnyOf(HasSubstr("rotate(-45)\" rx=\"49.1\" ry=\"24.5\""),
                                  HasSubstr("rotate(135)\" rx=\"49.1\" ry=\"24.5\"")));
}

TEST(StructurePicture, OneLandmarkFarAwayDoesNotShrinkTheRest) {
  StructureAndMotion map = wall_seen_from_a_path(100);
  const std::string svg = structure_picture(map, ViewPoint::kAbove);
  map.landmarks[50].position = {1e4, -1e4, 1e3};

  const std::string with_far = structure_picture(map, ViewPoint::kAbove);

  EXPECT_EQ(svg.substr(0, svg.find("<title>")), with_far.substr(0, with_far.find("<title>")));
}

TEST(StructurePicture, StaysBoundedAndStandsNumbersThatAreNone) {
  StructureAndMotion map = wall_seen_from_a_path(20000);
  map.landmarks[0].position.x() = std::nan("");
  map.landmarks[20].covariance(0, 0) = std::nan("");
  map.keyframes[0].T_map_camera.translation.x() = std::nan("");

  const std::string svg = structure_picture(map, ViewPoint::kAbove);

  EXPECT_LT(svg.size(), 400'000U);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(StructurePicture, IsEmptyWithoutAMap) { EXPECT_EQ(structure_picture({}, ViewPoint::kAbove), ""); }

}  // namespace
}  // namespace slamfuse::service
