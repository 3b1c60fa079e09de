// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_selection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "service/temporary_folder.hpp"
#include "visual_slam/drawn_scene.hpp"

namespace slamfuse::visual_slam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const cv::Size kSize(480, 360);

std::string as_pgm(const cv::Mat& picture) {
  std::string bytes = "P5\n" + std::to_string(picture.cols) + " " + std::to_string(picture.rows) + "\n255\n";
  for (int y = 0; y < picture.rows; ++y) bytes.append(picture.ptr<char>(y), static_cast<std::size_t>(picture.cols));
  return bytes;
}

/// Two posters, and a wall on which they may hang.
class FeatureSelectionTest : public ::testing::TestWithParam<FeatureKind> {
 protected:
  FeatureSelectionTest() {
    for (const auto& [name, seed] : {std::pair{"zebra", 11U}, std::pair{"antelope", 12U}}) {
      posters_.push_back(::slamfuse::visual_slam::testing::drawn_picture({160, 120}, seed, 120));
      service::put(folder_ / (std::string(name) + ".pgm"), as_pgm(posters_.back()));
    }
    service::put(folder_ / "notes.txt", "not a picture");
    options_.strategy = SelectionStrategy::kTopDown;
    options_.objects = folder_.path().string();
  }

  /// Hangs a poster on the wall, seen from aside.
  static void hang(const cv::Mat& poster, const std::array<cv::Point2f, 4>& corners, cv::Mat& wall) {
    const float w = static_cast<float>(poster.cols), h = static_cast<float>(poster.rows);
    const std::array<cv::Point2f, 4> own{{{0, 0}, {w, 0}, {w, h}, {0, h}}};
    const cv::Mat homography = cv::getPerspectiveTransform(own.data(), corners.data());
    cv::Mat seen, mask;
    cv::warpPerspective(poster, seen, homography, wall.size());
    cv::warpPerspective(cv::Mat(poster.size(), CV_8UC1, cv::Scalar(255)), mask, homography, wall.size());
    seen.copyTo(wall, mask);
  }

  service::TemporaryFolder folder_;
  std::vector<cv::Mat> posters_;  // zebra, antelope
  SelectionOptions options_;
  cv::Mat wall_ = cv::Mat(kSize, CV_8UC1, cv::Scalar(150));
};

TEST_P(FeatureSelectionTest, KnownObjectsAreFoundWhereTheyAre) {
  options_.object_features = GetParam();
  const std::array<cv::Point2f, 4> place{{{240, 60}, {400, 80}, {395, 190}, {245, 180}}};
  hang(posters_[0], place, wall_);
  const auto selection = FeatureSelection::create(options_);
  ASSERT_TRUE(selection) << selection.error().message;

  const SelectedRegion selected = selection->select(wall_);

  ASSERT_EQ(selected.objects.size(), 1U);
  EXPECT_EQ(selected.objects[0].name, "zebra");
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(cv::norm(selected.objects[0].outline[i] - place[i]), 6.0);
  EXPECT_NE(selected.mask.at<unsigned char>(120, 320), 0);
  EXPECT_EQ(selected.mask.at<unsigned char>(300, 100), 0);
  EXPECT_EQ(selected.object_at({320.0, 120.0}), "zebra");
  EXPECT_EQ(selected.object_at({100.0, 300.0}), "");
}

TEST_P(FeatureSelectionTest, WhatIsNotThereIsNotFound) {
  options_.object_features = GetParam();
  const auto selection = FeatureSelection::create(options_);
  ASSERT_TRUE(selection);
  for (const unsigned seed : {1U, 2U, 3U}) {
    EXPECT_TRUE(selection->select(::slamfuse::visual_slam::testing::drawn_picture(kSize, seed)).objects.empty());
  }
  EXPECT_TRUE(selection->select(wall_).objects.empty());
  EXPECT_EQ(cv::countNonZero(selection->select(wall_).mask), 0);
}

INSTANTIATE_TEST_SUITE_P(Features, FeatureSelectionTest, ::testing::Values(FeatureKind::kSift, FeatureKind::kOrb),
                         [](const auto& variant) { return variant.param == FeatureKind::kSift ? "Sift" : "Orb"; });

TEST_F(FeatureSelectionTest, BothIsTheUnionAndNoneIsEverywhere) {
  hang(posters_[1], {{{40, 40}, {190, 40}, {190, 150}, {40, 150}}}, wall_);
  cv::circle(wall_, {380, 280}, 12, cv::Scalar(20), cv::FILLED);
  const auto mask_of = [&](SelectionStrategy strategy) {
    options_.strategy = strategy;
    return FeatureSelection::create(options_)->select(wall_).mask;
  };
  const cv::Mat bottom_up = mask_of(SelectionStrategy::kBottomUp), top_down = mask_of(SelectionStrategy::kTopDown);

  EXPECT_EQ(cv::norm(mask_of(SelectionStrategy::kBoth), bottom_up | top_down, cv::NORM_INF), 0.0);
  EXPECT_NE(top_down.at<unsigned char>(100, 100), 0);
  EXPECT_EQ(top_down.at<unsigned char>(280, 380), 0);
  EXPECT_TRUE(mask_of(SelectionStrategy::kNone).empty());
}

TEST_F(FeatureSelectionTest, KnowsTheObjectsOfTheFolderByName) {
  EXPECT_THAT(ObjectDatabase::load(folder_.path(), options_)->names(), ElementsAre("antelope", "zebra"));
}

TEST_F(FeatureSelectionTest, RefusesFoldersAndPicturesThatAreNoUseAndNamesThem) {
  const auto message = [&](const std::string& folder) {
    options_.objects = folder;
    const auto selection = FeatureSelection::create(options_);
    return selection ? std::string("accepted") : selection.error().message;
  };
  EXPECT_THAT(message(""), HasSubstr("visual.selection.objects is empty"));
  EXPECT_THAT(message("/no/such/folder"), HasSubstr("/no/such/folder"));
  EXPECT_THAT(message((folder_ / "notes.txt").string()), HasSubstr("notes.txt"));
  const service::TemporaryFolder empty;
  EXPECT_THAT(message(empty.path().string()), HasSubstr("holds no picture"));

  const std::string here = folder_.path().string();
  service::put(folder_ / "broken.png", "not a picture");
  EXPECT_THAT(message(here), HasSubstr("broken.png"));
  std::filesystem::remove(folder_ / "broken.png");
  service::put(folder_ / "plain.pgm", as_pgm(cv::Mat(80, 80, CV_8UC1, cv::Scalar(9))));
  EXPECT_THAT(message(here), AllOf(HasSubstr("plain.pgm"), HasSubstr("0 features"), HasSubstr("at least 10")));
  std::filesystem::remove(folder_ / "plain.pgm");
  service::put(folder_ / "zebra.PPM", "P6");
  EXPECT_THAT(message(here), AllOf(HasSubstr("zebra.PPM"), HasSubstr("zebra.pgm"), HasSubstr("one name")));
}

TEST(PlausibleOutline, IsConvexNotTurnedOverAndOfSomeSize) {
  const cv::Size picture(320, 240);
  EXPECT_TRUE(is_plausible_outline({{{10, 10}, {110, 20}, {100, 90}, {15, 80}}}, picture));
  EXPECT_FALSE(is_plausible_outline({{{110, 10}, {10, 20}, {15, 80}, {100, 90}}}, picture)) << "a mirror image";
  EXPECT_FALSE(is_plausible_outline({{{10, 10}, {100, 90}, {110, 20}, {15, 80}}}, picture)) << "crossed";
  EXPECT_FALSE(is_plausible_outline({{{10, 10}, {14, 10}, {14, 14}, {10, 14}}}, picture)) << "tiny";
  EXPECT_FALSE(is_plausible_outline({{{-9e3F, -9e3F}, {9e3F, -9e3F}, {9e3F, 9e3F}, {-9e3F, 9e3F}}}, picture));
}

}  // namespace
}  // namespace slamfuse::visual_slam
