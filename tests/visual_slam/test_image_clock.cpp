// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_clock.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "common/time.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr common::Nanoseconds kStart = 1'700'000'000 * common::kNanosecondsPerSecond;

/// A robot that turns to and fro, or stands, among blots far away all round.
class ImageClockTest : public ::testing::Test {
 protected:
  ImageClockTest() {
    testing::Noise noise(5);
    for (int i = 0; i < 250; ++i) {
      const double azimuth = 2.0 * std::numbers::pi * noise.uniform();
      blots_.emplace_back(std::cos(azimuth), std::sin(azimuth), 0.7 * noise.uniform() - 0.35);
    }
  }

  /// [rad] at `time` [s].
  double heading(double time) const { return turns_ ? 0.6 * std::sin(0.9 * time) + 0.3 * std::sin(2.3 * time) : 0.0; }

  cv::Mat picture(double time) const {
    cv::Mat image(480, 640, CV_8UC1, cv::Scalar(60));
    const Eigen::AngleAxisd turn(-heading(time), Eigen::Vector3d::UnitZ());
    for (std::size_t i = 0; i < blots_.size(); ++i) {
      const auto pixel = camera_.calibration.project(camera_.R_base_camera.transpose() * (turn * blots_[i]));
      if (!pixel) continue;
      constexpr int kShift = 4;  // parts of a pixel count
      const cv::Point place(static_cast<int>(std::lround(pixel->x() * (1 << kShift))),
                            static_cast<int>(std::lround(pixel->y() * (1 << kShift))));
      cv::circle(image, place, (5 + static_cast<int>(i % 5)) << kShift,
                 cv::Scalar(100 + 5 * static_cast<double>(i % 30)), cv::FILLED, cv::LINE_AA, kShift);
    }
    return image;
  }

  /// Drives for `seconds` with pictures whose stamps are wrong by `offset`; returns the correction [s].
  double drive(ImageClock& clock, double seconds, double offset) {
    double next_picture = 0.05;
    for (double time = 0.0; time < seconds; time += 0.05) {
      common::WheelOdometry odometry;
      odometry.stamp = kStart + common::from_seconds(time);
      odometry.pose.theta = common::Pose2{0.0, 0.0, heading(time)}.theta;
      clock.add(odometry);
      if (time < next_picture) continue;
      clock.watch(picture(next_picture), kStart + common::from_seconds(next_picture + offset));
      next_picture += 0.2;
    }
    return common::to_seconds(clock.correction());
  }

  bool turns_ = true;
  Camera camera_ = testing::make_camera("cam0", 0.6);
  std::vector<Eigen::Vector3d> blots_;
};

TEST_F(ImageClockTest, FindsByHowMuchStampsAreLateOrEarly) {
  for (const double offset : {-0.2, 0.1, 0.4}) {
    ImageClock clock({}, {}, camera_);
    EXPECT_NEAR(drive(clock, 18.0, offset), -offset, 0.015) << offset;
  }
}

TEST_F(ImageClockTest, LetsRightStampsBe) {
  ImageClock clock({}, {}, camera_);
  EXPECT_EQ(drive(clock, 18.0, 0.0), 0.0);
}

TEST_F(ImageClockTest, SaysNothingWithoutATurn) {
  turns_ = false;
  ImageClock clock({}, {}, camera_);
  EXPECT_EQ(drive(clock, 15.0, 0.3), 0.0);
}

TEST_F(ImageClockTest, ClocksThatAreAlikeAreOne) {
  std::vector<ImageClock> clocks(4, ImageClock({}, {}, camera_));
  const std::vector<double> offsets = {0.2, 0.204, 0.0, -0.3};
  for (std::size_t i = 0; i < clocks.size(); ++i) drive(clocks[i], 18.0, offsets[i]);
  const common::Nanoseconds alone = clocks[3].correction();
  ImageClock::share(clocks);
  EXPECT_EQ(clocks[0].correction(), clocks[1].correction());
  EXPECT_NEAR(common::to_seconds(clocks[0].correction()), -0.202, 0.01);
  EXPECT_EQ(clocks[2].correction(), 0) << "its stamps were never wrong";
  EXPECT_EQ(clocks[3].correction(), alone);
}

TEST_F(ImageClockTest, CanBeSwitchedOff) {
  ImageClockOptions options;
  options.correct = false;
  ImageClock clock(options, {}, camera_);
  EXPECT_EQ(drive(clock, 18.0, 0.3), 0.0);
}

}  // namespace
}  // namespace slamfuse::visual_slam
