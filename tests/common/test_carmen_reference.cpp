// SPDX-License-Identifier: BSD-3-Clause
#include "common/carmen_reference.hpp"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/temporary_file.hpp"

namespace slamfuse::common {
namespace {

using testing::HasSubstr;

constexpr const char* kReference =
    "# raw_scan_index ipc_timestamp logger_timestamp x y theta\n"
    "169 976052890.244111 32.906827 0.6003 -0.0320 -0.35467\n"
    "178 976052892.442400 35.105116 0.6823 -0.1001 -0.93880\n";

TEST(CarmenReference, KeepsTheIpcStampAndTheOrder) {
  const TemporaryFile file("intel.reference.txt", kReference);

  const auto trajectory = read_carmen_reference(file.path());

  ASSERT_TRUE(trajectory.has_value()) << trajectory.error().message;
  ASSERT_EQ(trajectory->size(), 2u);
  EXPECT_EQ(trajectory->at(0).stamp, 976052890244111000);
  EXPECT_EQ(trajectory->at(1).pose.vector(), Eigen::Vector3d(0.6823, -0.1001, -0.93880));
}

TEST(CarmenReference, IsTheFileWithSixColumns) {
  EXPECT_TRUE(is_carmen_reference(TemporaryFile("a.txt", kReference).path()));
  EXPECT_FALSE(is_carmen_reference(TemporaryFile("b.tum", "1 0 0 0 0 0 0 1\n").path()));
  EXPECT_FALSE(is_carmen_reference(TemporaryFile("c.txt", "# only a comment\n").path()));
  EXPECT_FALSE(is_carmen_reference("/no/such/file"));
}

TEST(CarmenReference, RefusesBrokenLinesWithTheirPlace) {
  const auto message = [](const std::string& text) {
    return read_carmen_reference(TemporaryFile("r.txt", text).path()).error().message;
  };
  EXPECT_THAT(message("1 2 3 4 5\n"), HasSubstr("r.txt:1: 5 columns, expected 6"));
  EXPECT_THAT(message("1 2 3 4 5 6\n1 2 3 4 nan 6\n"), HasSubstr("r.txt:2: column 5 is 'nan'"));
  EXPECT_THAT(message("1 x 3 4 5 6\n"), HasSubstr("r.txt:1: column 2 is 'x', expected a time"));
}

TEST(SensorTrajectory, PlacesTheSensorAheadOfTheBase) {
  const Trajectory2 base = {{5, {1.0, 2.0, std::numbers::pi / 2}}};

  const Trajectory2 sensor = sensor_trajectory(base, {0.3, 0.0, 0.1});

  ASSERT_EQ(sensor.size(), 1u);
  EXPECT_EQ(sensor[0].stamp, 5);
  EXPECT_NEAR(sensor[0].pose.x, 1.0, 1e-15);
  EXPECT_NEAR(sensor[0].pose.y, 2.3, 1e-15);
  EXPECT_NEAR(sensor[0].pose.theta, std::numbers::pi / 2 + 0.1, 1e-15);
}

}  // namespace
}  // namespace slamfuse::common
