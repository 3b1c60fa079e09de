// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/saliency.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "visual_slam/drawn_scene.hpp"

namespace slamfuse::visual_slam {
namespace {

const cv::Size kSize(320, 240);

/// Mean of the map (or region) inside and outside a rectangle of the picture.
std::pair<double, double> means(const cv::Mat& map, const cv::Rect& inside) {
  cv::Mat full;
  map.convertTo(full, CV_32F);
  cv::resize(full, full, kSize);
  cv::Mat mask = cv::Mat::zeros(kSize, CV_8UC1);
  mask(inside).setTo(255);
  return {cv::mean(full, mask)[0], cv::mean(full, ~mask)[0]};
}

TEST(Saliency, ASpotOnAPlainWallStandsOut) {
  cv::Mat picture(kSize, CV_8UC1, cv::Scalar(120));
  cv::circle(picture, {200, 100}, 12, cv::Scalar(220), cv::FILLED);

  const auto [inside, outside] = means(saliency_map(picture), {170, 70, 60, 60});

  EXPECT_GT(inside, 10.0 * outside);
}

TEST(Saliency, TheOddOneAmongManyStandsOutByItsDirection) {
  cv::Mat picture(480, 640, CV_8UC1, cv::Scalar(120));
  const cv::Point odd(400, 240);
  for (int y = 80; y < 450; y += 80) {
    for (int x = 80; x < 600; x += 80) {
      const cv::Size bar = cv::Point(x, y) == odd ? cv::Size(56, 10) : cv::Size(10, 56);
      cv::rectangle(picture, cv::Rect({x - bar.width / 2, y - bar.height / 2}, bar), cv::Scalar(200), cv::FILLED);
    }
  }

  const cv::Mat map = saliency_map(picture);
  double highest = 0.0;
  cv::Point place;
  cv::minMaxLoc(map, nullptr, &highest, nullptr, &place);

  EXPECT_LE(cv::norm(place * (picture.cols / map.cols) - odd), 24.0);
  EXPECT_GT(highest, 2.0 * static_cast<double>(map.at<float>(20, 25))) << "its neighbour below";
}

TEST(Saliency, ColourCountsWhereThereIsColourOnly) {
  cv::Mat picture(kSize, CV_8UC3, cv::Scalar(120, 120, 120));
  cv::circle(picture, {80, 160}, 14, cv::Scalar(110, 110, 148), cv::FILLED);  // as bright as the wall, but red
  cv::Mat gray;
  cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);

  const auto [inside, outside] = means(saliency_map(picture), {50, 130, 60, 60});

  EXPECT_GT(inside, 10.0 * outside);
  EXPECT_LT(means(saliency_map(gray), {50, 130, 60, 60}).first, 0.5 * inside);
}

TEST(Saliency, PlainAndTinyPicturesStandOutNowhere) {
  for (const double gray : {0.0, 128.0, 255.0}) {
    EXPECT_EQ(cv::countNonZero(salient_region(cv::Mat(kSize, CV_8UC1, cv::Scalar(gray)), 0.5)), 0);
  }
  EXPECT_EQ(cv::countNonZero(salient_region(testing::drawn_picture({40, 40}, 1, 20), 0.5)), 0);
}

TEST(SalientRegion, CoversAboutTheShareAskedFor) {
  const cv::Mat picture = testing::drawn_picture(kSize, 4);
  for (const double share : {0.2, 0.5, 0.8}) {
    const cv::Mat region = salient_region(picture, share);
    ASSERT_EQ(region.size(), kSize);
    ASSERT_EQ(region.type(), CV_8UC1);
    EXPECT_NEAR(static_cast<double>(cv::countNonZero(region)) / kSize.area(), share, 0.12);
  }
  EXPECT_EQ(cv::countNonZero(salient_region(picture, 0.0)), 0);
  EXPECT_GT(cv::countNonZero(salient_region(picture, 1.0)), 0.95 * kSize.area());
}

TEST(Saliency, IsTheSameWhateverTheNumberOfThreads) {
  const cv::Mat picture = testing::drawn_picture({640, 480}, 5);
  cv::setNumThreads(1);
  const cv::Mat one = saliency_map(picture);
  for (const int threads : {2, 5}) {
    cv::setNumThreads(threads);
    EXPECT_EQ(cv::norm(one, saliency_map(picture), cv::NORM_INF), 0.0) << threads;
  }
  cv::setNumThreads(1);
}

}  // namespace
}  // namespace slamfuse::visual_slam
