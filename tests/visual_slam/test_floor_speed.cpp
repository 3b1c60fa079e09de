// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/floor_speed.hpp"

#include <cmath>
#include <functional>
#include <utility>

#include <gtest/gtest.h>

#include "common/angle.hpp"
#include "common/pose2.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr double kSeconds = 0.2;
constexpr double kHeading = 0.3;  // [rad] in which the scene is driven through
constexpr common::Nanoseconds kStart = 1'700'000'000'000'000'000;
constexpr common::Nanoseconds kFrame = 200'000'000;

// Blots some centimetres wide, everywhere different.
double texture(double x, double y) {
  double value = 0.0;
  for (int wave = 0; wave < 10; ++wave) {
    const double direction = 2.4 * wave;
    const double number = 25.0 + 7.3 * wave;  // [rad/m]
    value += std::sin(number * (x * std::cos(direction) + y * std::sin(direction)) + 1.7 * wave * wave);
  }
  return 120.0 + 22.0 * value;
}

// A plain with a wall across x = `wall`.
class Scene {
 public:
  std::function<double(double, double)> floor = texture;
  double wall = 1e9;

  cv::Mat picture(const Camera& camera, const Pose2& robot) const {
    cv::Mat image(camera.calibration.height, camera.calibration.width, CV_8UC1);
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const Eigen::Vector3d ray = camera.R_base_camera * camera.calibration.undistort({column, row}).homogeneous();
        image.at<unsigned char>(row, column) = cv::saturate_cast<unsigned char>(colour(camera, robot, ray));
      }
    }
    return image;
  }

 private:
  double colour(const Camera& camera, const Pose2& robot, const Eigen::Vector3d& ray) const {
    const Eigen::Vector2d centre = robot * Eigen::Vector2d(camera.t_base_camera.head<2>());
    const Eigen::Vector2d along = Eigen::Rotation2Dd(robot.theta) * ray.head<2>();
    const double to_floor = ray.z() < 0.0 ? -camera.t_base_camera.z() / ray.z() : 1e9;
    const double to_wall = along.x() > 0.0 ? (wall - centre.x()) / along.x() : 1e9;
    const double way = std::min(to_floor, to_wall);
    if (way > 30.0) return 128.0;
    const Eigen::Vector2d at = centre + way * along;
    return to_floor < to_wall ? floor(at.x(), at.y()) : texture(at.y(), camera.t_base_camera.z() + way * ray.z());
  }
};

std::optional<FloorSpeed::Reading> read(const Scene& scene, const Camera& camera, double way, double turn,
                                        FloorSpeedOptions options = {}) {
  FloorSpeed speed(options, 1);
  const Pose2 before{1.0, -2.0, kHeading};
  EXPECT_FALSE(speed.read(0, camera, scene.picture(camera, before), kStart)) << "there is nothing to compare with";
  speed.moved(kSeconds, way / kSeconds, turn / kSeconds);
  return speed.read(0, camera, scene.picture(camera, before * common::exp_se2({way, 0.0, turn})), kStart + kFrame);
}

TEST(FloorSpeed, ReadsTheWayAheadAndBackAndInTurns) {
  for (const double yaw : {0.0, 0.9}) {
    const Camera camera = testing::make_camera("cam0", yaw);
    for (const auto& [way, turn] : {std::pair{0.08, 0.0}, {0.2, 0.15}, {0.05, -0.1}, {0.0, 0.0}, {-0.03, 0.0}}) {
      const auto reading = read({}, camera, way, turn);
      ASSERT_TRUE(reading) << yaw << ' ' << turn << ' ' << way;
      EXPECT_NEAR(reading->speed * kSeconds, way, 0.003) << yaw << ' ' << turn;
      EXPECT_NEAR(reading->seconds, kSeconds, 1e-9);
    }
  }
}

TEST(FloorSpeed, TheTurnMayComeInParts) {
  const Camera camera = testing::make_camera("cam0", 0.9);
  const Scene scene;
  FloorSpeed speed({}, 2);
  speed.read(0, camera, scene.picture(camera, {}), kStart);
  speed.moved(kSeconds / 2.0, 0.5, 0.6);
  speed.moved(kSeconds / 2.0, 0.5, 0.4);
  const auto reading = speed.read(0, camera, scene.picture(camera, common::exp_se2({0.1, 0.0, 0.1})), kStart + kFrame);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->speed * kSeconds, 0.1, 0.003);
}

// At 30 Hz several steps lie between the pictures that are compared, and what is told is the speed of the last.
TEST(FloorSpeed, TellsTheSpeedOfTheLastStep) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const Scene scene;
  FloorSpeed speed({}, 1);
  speed.read(0, camera, scene.picture(camera, {}), kStart);
  speed.moved(kSeconds / 2.0, 0.3, 0.0);
  EXPECT_FALSE(speed.read(0, camera, scene.picture(camera, {0.03, 0.0, 0.0}), kStart + kFrame / 4));
  speed.moved(kSeconds / 2.0, 0.5, 0.0);
  const auto reading = speed.read(0, camera, scene.picture(camera, {0.08, 0.0, 0.0}), kStart + kFrame);
  ASSERT_TRUE(reading);
  EXPECT_NEAR(reading->speed, 0.5, 0.015);
}

TEST(FloorSpeed, AFloorWithoutTextureTellsNothing) {
  Scene scene;
  scene.floor = [](double, double) { return 120.0; };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

// Which way a striped floor moves along its stripes nobody can tell.
TEST(FloorSpeed, StripesAlongTheWayTellNothing) {
  Scene scene;
  scene.floor = [](double x, double y) {
    return 120.0 + 80.0 * std::sin(60.0 * (y * std::cos(kHeading) - x * std::sin(kHeading)));
  };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

// Tiles look the same after a whole tile.
TEST(FloorSpeed, APatternThatRepeatsAlongTheWayTellsNothing) {
  Scene scene;
  scene.floor = [](double x, double y) {
    const double along = x * std::cos(kHeading) + y * std::sin(kHeading);
    const double across = y * std::cos(kHeading) - x * std::sin(kHeading);
    return 120.0 + 60.0 * std::sin(90.0 * along) * std::sin(90.0 * across);
  };
  EXPECT_FALSE(read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0));
}

TEST(FloorSpeed, AWallIsNoFloor) {
  int readings = 0;
  for (const double distance : {1.6, 2.2, 3.0}) {
    Scene scene;
    scene.wall = 1.0 + distance;
    const auto reading = read(scene, testing::make_camera("cam0", 0.0), 0.1, 0.0);
    if (!reading) continue;
    ++readings;
    EXPECT_NEAR(reading->speed * kSeconds, 0.1, 0.005) << distance;
  }
  EXPECT_GE(readings, 1) << "there is floor before the farthest";
}

TEST(FloorSpeed, PicturesTooNearOrTooFarApartAreNotCompared) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const Scene scene;
  const cv::Mat first = scene.picture(camera, {});
  const cv::Mat second = scene.picture(camera, {0.05, 0.0, 0.0});
  FloorSpeed speed({}, 1);
  speed.read(0, camera, first, kStart);
  EXPECT_FALSE(speed.read(0, camera, second, kStart + kFrame / 4)) << "less than a tenth of a second";
  const auto reading = speed.read(0, camera, second, kStart + kFrame);
  ASSERT_TRUE(reading) << "the first picture is still the one to compare with";
  EXPECT_NEAR(reading->speed * kSeconds, 0.05, 0.003);
  EXPECT_FALSE(speed.read(0, camera, first, kStart + 10 * kFrame)) << "after a gap";
  EXPECT_FALSE(speed.read(0, camera, first, kStart)) << "of another time";
  EXPECT_TRUE(speed.read(0, camera, second, kStart + kFrame)) << "which goes on";
}

// What is told need not be the floor's: a bed lower than the camera tells more than the truth, and for a while.
TEST(FloorSpeed, ASpeedTheRobotCannotHaveGotToIsNotTold) {
  const Camera camera = testing::make_camera("cam0", 0.0);
  const Scene scene;
  FloorSpeed speed({}, 1);
  common::Nanoseconds stamp = kStart;
  double x = 0.0;
  const auto drive = [&](double way) {
    x += way;
    stamp += kFrame;
    return speed.read(0, camera, scene.picture(camera, {x, 0.0, 0.0}), stamp);
  };
  drive(0.0);
  EXPECT_TRUE(drive(0.06));
  EXPECT_TRUE(drive(0.09)) << "by 0.15 m/s in a fifth of a second";
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(drive(0.22)) << "by 0.65 m/s";
  EXPECT_TRUE(drive(0.09));
}

TEST(FloorSpeed, ReadsNothingWhenSwitchedOffOrWithTheCameraOnTheFloor) {
  FloorSpeedOptions off;
  off.enabled = false;
  EXPECT_FALSE(read({}, testing::make_camera("cam0", 0.0), 0.1, 0.0, off));
  Camera low = testing::make_camera("cam0", 0.0);
  low.t_base_camera.z() = 0.0;
  EXPECT_FALSE(FloorSpeed({}, 1).read(0, low, cv::Mat(480, 640, CV_8UC1, cv::Scalar(100)), kStart));
}

}  // namespace
}  // namespace slamfuse::visual_slam
