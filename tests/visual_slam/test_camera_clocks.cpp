// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/camera_clocks.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

common::Image image(common::Nanoseconds stamp) {
  common::Image result;
  result.sensor = "cam0";
  result.stamp = stamp;
  result.width = 640;
  result.height = 480;
  result.pixels = std::make_shared<const std::vector<std::uint8_t>>(640 * 480, std::uint8_t{90});
  return result;
}

class CameraClocksTest : public ::testing::Test {
 protected:
  CameraClocks clocks(bool correct) const {
    ImageClockOptions options;
    options.correct = correct;
    options.kept_images = 1.0;  // [MB], three images
    return {options, {}, cameras_};
  }

  std::vector<CameraTracks> cameras_{CameraTracks(testing::make_camera("cam0", 0.3))};
};

TEST_F(CameraClocksTest, KeepsTheNewestImagesWhileAClockMayBeWrong) {
  CameraClocks watching = clocks(true);
  for (int i = 1; i <= 5; ++i) {
    EXPECT_TRUE(watching.watch(0, image(i)).empty());
    watching.keep(image(i));
  }
  const std::vector<common::Image> kept = watching.kept();
  ASSERT_EQ(kept.size(), 3U);
  EXPECT_EQ(kept.front().stamp, 3);
  EXPECT_EQ(watching.first_kept(), 3);
  EXPECT_EQ(watching.correction(0), 0);
  watching.forget_kept();
  EXPECT_TRUE(watching.kept().empty());
}

TEST_F(CameraClocksTest, KeepsNothingWhereClocksAreTakenAsTheyAre) {
  CameraClocks settled = clocks(false);
  settled.keep(image(1));
  EXPECT_TRUE(settled.kept().empty());
}

}  // namespace
}  // namespace slamfuse::visual_slam
