// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/front_end.hpp"

#include <gtest/gtest.h>

#include <string>

#include <opencv2/core.hpp>

#include "visual_slam/drawn_scene.hpp"

namespace slamfuse::visual_slam {
namespace {

struct Variant {
  const char* name;
  FrontEndKind kind;
  DescriptorSearch search;
  double tolerance;  // [px]
};

std::ostream& operator<<(std::ostream& out, const Variant& variant) { return out << variant.name; }

/// Every front end on a picture and the same picture moved.
class FrontEndTest : public ::testing::TestWithParam<Variant> {
 protected:
  FrontEndTest() {
    options_.kind = GetParam().kind;
    options_.search = GetParam().search;
    first_ = testing::drawn_picture({320, 240}, 1);
    homography_ = (cv::Mat_<double>(3, 3) << 1.02, 0.03, 5.0, -0.03, 1.02, 9.0, 1e-5, 2e-5, 1.0);
    second_ = testing::moved_picture(first_, homography_);
  }

  Eigen::Vector2d moved(const Eigen::Vector2d& pixel) const {
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> matrix(homography_.ptr<double>());
    return (matrix * pixel.homogeneous()).hnormalized();
  }

  /// Features of the first picture, predicted `off` pixels from where they are in the second.
  std::vector<ExpectedFeature> expected(std::span<const Eigen::Vector2d> pixels, const Eigen::Vector2d& off) const {
    std::vector<ExpectedFeature> result;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      result.push_back({static_cast<std::int64_t>(100 + i), pixels[i], moved(pixels[i]) + off});
    }
    return result;
  }

  struct Result {
    std::vector<Eigen::Vector2d> detected;
    std::vector<FoundFeature> found;
  };

  Result run(int threads, const Eigen::Vector2d& off = {4.0, -3.0}) const {
    cv::setNumThreads(threads);
    const auto front_end = make_front_end(options_, 1);
    front_end->follow(0, first_, {});
    Result result;
    result.detected = front_end->detect(0, {}, 50, cv::Mat());
    result.found = front_end->follow(0, second_, expected(result.detected, off));
    return result;
  }

  FrontEndOptions options_;
  cv::Mat first_, second_, homography_;
};

TEST_P(FrontEndTest, FindsMostFeaturesAgainWhereTheyWentAndHardlyAnyElsewhere) {
  const Result result = run(1);

  ASSERT_GT(result.detected.size(), 35U);
  EXPECT_GT(result.found.size(), result.detected.size() / 2);
  std::size_t wrong = 0;
  for (const FoundFeature& feature : result.found) {
    const Eigen::Vector2d truth = moved(result.detected[static_cast<std::size_t>(feature.id - 100)]);
    if ((feature.pixel - truth).norm() > GetParam().tolerance) ++wrong;
  }
  EXPECT_LE(wrong, result.found.size() / 10);
}

TEST_P(FrontEndTest, GivesTheSameWhateverTheNumberOfThreadsAndEachTime) {
  const Result one = run(1);
  for (const int threads : {1, 2, 5}) {
    const Result other = run(threads);
    ASSERT_EQ(one.detected, other.detected) << threads;
    ASSERT_EQ(one.found.size(), other.found.size()) << threads;
    for (std::size_t i = 0; i < one.found.size(); ++i) {
      EXPECT_EQ(one.found[i].id, other.found[i].id);
      EXPECT_EQ(one.found[i].pixel, other.found[i].pixel);
    }
  }
  cv::setNumThreads(1);
}

TEST_P(FrontEndTest, DetectsOnlyInTheRegionAndAwayFromWhatIsTaken) {
  const auto front_end = make_front_end(options_, 2);
  front_end->follow(1, first_, {});
  cv::Mat region = cv::Mat::zeros(first_.size(), CV_8UC1);
  region(cv::Rect(160, 0, 160, 240)).setTo(255);
  const std::vector<Eigen::Vector2d> taken{{200.0, 100.0}, {260.0, 150.0}};

  const std::vector<Eigen::Vector2d> found = front_end->detect(1, taken, 30, region);

  EXPECT_GT(found.size(), 10U);
  EXPECT_LE(found.size(), 30U);
  for (const Eigen::Vector2d& pixel : found) {
    EXPECT_GE(pixel.x(), 159.5);
    for (const Eigen::Vector2d& other : taken) EXPECT_GE((pixel - other).norm(), options_.min_spacing);
  }
  EXPECT_TRUE(front_end->detect(0, {}, 30, cv::Mat()).empty()) << "nothing was seen by the other camera yet";
}

TEST_P(FrontEndTest, FindsNothingInEmptyPictures) {
  const auto front_end = make_front_end(options_, 1);
  front_end->follow(0, first_, {});
  const std::vector<Eigen::Vector2d> detected = front_end->detect(0, {}, 50, cv::Mat());

  const cv::Mat black = cv::Mat::zeros(first_.size(), CV_8UC1);
  EXPECT_TRUE(front_end->follow(0, black, expected(detected, {0.0, 0.0})).empty());
  EXPECT_TRUE(front_end->detect(0, {}, 50, cv::Mat()).empty());
  EXPECT_TRUE(front_end->follow(0, first_, expected(detected, {0.0, 0.0})).empty());
}

INSTANTIATE_TEST_SUITE_P(
    All, FrontEndTest,
    ::testing::Values(Variant{"ShiTomasiKlt", FrontEndKind::kShiTomasiKlt, DescriptorSearch::kComplete, 1.0},
                      Variant{"SiftComplete", FrontEndKind::kSift, DescriptorSearch::kComplete, 2.0},
                      Variant{"SiftFlann", FrontEndKind::kSift, DescriptorSearch::kFlann, 2.0},
                      Variant{"OrbComplete", FrontEndKind::kOrb, DescriptorSearch::kComplete, 5.0},
                      Variant{"OrbFlann", FrontEndKind::kOrb, DescriptorSearch::kFlann, 5.0}),
    [](const auto& variant) { return std::string(variant.param.name); });

/// Only features matched by descriptors are found where the prediction is far off.
TEST(DescriptorFrontEnd, LooksAsFarAsTheSearchRadiusAndNoFarther) {
  const cv::Mat picture = testing::drawn_picture({320, 240}, 2);
  for (const double radius : {20.0, 60.0}) {
    FrontEndOptions options;
    options.kind = FrontEndKind::kOrb;
    options.search_radius = radius;
    const auto front_end = make_front_end(options, 1);
    front_end->follow(0, picture, {});
    std::vector<ExpectedFeature> expected;
    for (const Eigen::Vector2d& pixel : front_end->detect(0, {}, 40, cv::Mat())) {
      expected.push_back({static_cast<std::int64_t>(expected.size()), pixel, pixel + Eigen::Vector2d(40.0, 0.0)});
    }

    std::size_t back = 0;
    for (const FoundFeature& found : front_end->follow(0, picture, expected)) {
      back += (found.pixel - expected[static_cast<std::size_t>(found.id)].last).norm() < 1.0 ? 1 : 0;
    }

    if (radius > 40.0) {
      EXPECT_GT(back, expected.size() / 2);
    } else {
      EXPECT_EQ(back, 0U);
    }
  }
}

}  // namespace
}  // namespace slamfuse::visual_slam
