// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_sampler.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;

void offer(ImageSampler& sampler, const std::string& camera, common::Nanoseconds stamp) {
  if (!sampler.wants(camera, stamp)) return;
  common::AnnotatedImage image;
  image.image.sensor = camera;
  image.image.stamp = stamp;
  sampler.keep(image);
}

TEST(ImageSampler, KeepsAFewImagesSpreadOverARunOfAnyLength) {
  for (const int seconds : {3, 60, 5000}) {
    ImageSampler sampler;
    for (int i = 0; i <= 5 * seconds; ++i) offer(sampler, "cam0", i * kSecond / 5);

    const auto images = sampler.images();

    EXPECT_LE(images.size(), ImageSampler::kMaxImages);
    EXPECT_GE(images.size(), std::min<std::size_t>(4, static_cast<std::size_t>(seconds)));
    EXPECT_EQ(images.front().image.stamp, 0);
    EXPECT_GE(images.back().image.stamp, seconds * kSecond / 2);
  }
}

TEST(ImageSampler, SamplesEveryCamera) {
  ImageSampler sampler;

  for (int i = 0; i < 100; ++i) {
    offer(sampler, "cam1", i * kSecond);
    offer(sampler, "cam0", i * kSecond);
  }

  const auto images = sampler.images();
  ASSERT_FALSE(images.empty());
  EXPECT_EQ(images.front().image.sensor, "cam0");
  EXPECT_EQ(images.back().image.sensor, "cam1");
}

}  // namespace
}  // namespace slamfuse::visual_slam
