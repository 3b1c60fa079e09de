// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/turn_search.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "common/angle.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

/// Blots on a wall far away, and where they are.
class BlotsTest : public ::testing::Test {
 protected:
  BlotsTest() {
    testing::Noise noise(3);
    for (int i = 0; i < 40; ++i) blots_.emplace_back(60.0 + 520.0 * noise.uniform(), 60.0 + 360.0 * noise.uniform());
  }

  /// The picture after base_link has turned.
  cv::Mat picture(double turn) const {
    cv::Mat image(480, 640, CV_8UC1, cv::Scalar(60));
    for (std::size_t i = 0; i < blots_.size(); ++i) {
      const auto pixel = turned_pixel(camera_, blots_[i], turn);
      if (!pixel) continue;
      cv::circle(image, {static_cast<int>(pixel->x()), static_cast<int>(pixel->y())}, 6 + static_cast<int>(i % 5),
                 cv::Scalar(100 + 3 * static_cast<double>(i)), cv::FILLED);
    }
    return image;
  }

  std::vector<ExpectedFeature> expected() const {
    std::vector<ExpectedFeature> features;
    for (const Eigen::Vector2d& blot : blots_) features.push_back({0, blot, blot});
    return features;
  }

  Camera camera_ = testing::make_camera("cam0", 0.6);
  std::vector<Eigen::Vector2d> blots_;
};

TEST_F(BlotsTest, TurningLeftMovesWhatIsSeenToTheRight) {
  const auto moved = turned_pixel(camera_, {319.5, 239.5}, 0.1);

  ASSERT_TRUE(moved);
  EXPECT_NEAR(moved->x(), 319.5 + 500.0 * std::tan(0.1), 1e-6);
  EXPECT_NEAR(moved->y(), 239.5, 1e-6);
}

TEST_F(BlotsTest, AnUnforeseenTurnIsFound) {
  for (const double turn : {-0.2, -0.05, 0.0, 0.12, 0.2}) {
    TurnSearch search({}, 1);
    search.find(0, camera_, picture(0.0), {});

    EXPECT_NEAR(search.find(0, camera_, picture(turn), expected()), turn, 0.012) << turn;
  }
}

TEST_F(BlotsTest, NothingToGoByMeansNoTurn) {
  TurnSearch search({}, 1);

  EXPECT_EQ(search.find(0, camera_, picture(0.0), expected()), 0.0) << "the first picture";
  EXPECT_EQ(search.find(0, camera_, picture(0.1), {}), 0.0) << "no features";
  EXPECT_EQ(search.find(0, camera_, cv::Mat(480, 640, CV_8UC1, cv::Scalar(0)), expected()), 0.0) << "dark";
}

}  // namespace
}  // namespace slamfuse::visual_slam
