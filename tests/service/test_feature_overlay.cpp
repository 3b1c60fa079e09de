// SPDX-License-Identifier: BSD-3-Clause
#include "service/feature_overlay.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/markup_checks.hpp"

namespace slamfuse::service {
namespace {

using common::FeatureOutcome;
using testing::HasSubstr;
using testing::Not;

common::AnnotatedImage image_of(int width, int height) {
  common::AnnotatedImage annotated;
  annotated.image.sensor = "cam0";
  annotated.image.width = width;
  annotated.image.height = height;
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.push_back(static_cast<std::uint8_t>((i * 7919) >> 5));
  annotated.image.pixels = std::make_shared<const std::vector<std::uint8_t>>(std::move(pixels));
  annotated.features = {{{100.0, 50.0}, FeatureOutcome::kFollowed},
                        {{200.0, 60.0}, FeatureOutcome::kFollowed},
                        {{300.0, 70.0}, FeatureOutcome::kRejected}};
  return annotated;
}

TEST(FeatureOverlay, MarksFeaturesByKindOnASmallPicture) {
  const std::string svg = feature_overlay(image_of(640, 480));

  EXPECT_EQ(nesting_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("viewBox=\"0 0 480 360\""));
  EXPECT_THAT(svg, HasSubstr("href=\"data:image/jpeg;base64,/9j/"));
  EXPECT_EQ(occurrences(svg, "class=\"feature followed\""), 1U) << "one path holds all of a kind";
  EXPECT_EQ(occurrences(svg, "class=\"feature rejected\""), 1U);
  EXPECT_THAT(svg, HasSubstr("M221.4 48.9")) << "the cross of the rejected one begins 4 units up and left of it";
  EXPECT_THAT(svg, Not(HasSubstr("feature new")));
  EXPECT_LT(svg.size(), 250'000U) << "even noise stays small";
}

TEST(FeatureOverlay, LeavesSmallPicturesAtTheirSize) {
  EXPECT_THAT(feature_overlay(image_of(320, 240)), HasSubstr("viewBox=\"0 0 320 240\""));
}

TEST(FeatureOverlay, IsEmptyWithoutPixels) { EXPECT_EQ(feature_overlay({}), ""); }

TEST(FeatureOverlay, CountsInWords) {
  EXPECT_EQ(features_in_words(image_of(8, 8)), "2 followed, 0 recognised, 1 rejected, 0 new; TRACKING");
}

TEST(FeatureOverlay, HasALegendOfEveryKind) {
  const std::string svg = feature_legend();
  EXPECT_EQ(nesting_fault(svg), "");
  for (const char* kind : {"followed", "recognised", "rejected", "new"}) {
    EXPECT_THAT(svg, HasSubstr(std::string("class=\"feature ") + kind));
    EXPECT_THAT(svg, HasSubstr(std::string(">") + kind + "<"));
  }
}

}  // namespace
}  // namespace slamfuse::service
