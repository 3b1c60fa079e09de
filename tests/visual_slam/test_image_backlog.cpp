// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/image_backlog.hpp"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

common::Image image(common::Nanoseconds stamp, std::size_t bytes = 100) {
  common::Image image;
  image.stamp = stamp;
  image.pixels = std::make_shared<const std::vector<std::uint8_t>>(bytes);
  return image;
}

TEST(ImageBacklog, KeepsTheLatestThatFit) {
  ImageBacklog backlog(350);
  for (int stamp = 1; stamp <= 5; ++stamp) backlog.add(image(stamp));
  ASSERT_EQ(backlog.images().size(), 3u);
  EXPECT_EQ(backlog.images().front().stamp, 3);
  EXPECT_EQ(backlog.images().back().stamp, 5);
  backlog.add(image(6, 300));
  EXPECT_EQ(backlog.images().size(), 1u);
}

TEST(ImageBacklog, IsEmptyAfterClear) {
  ImageBacklog backlog(350);
  backlog.add(image(1));
  backlog.clear();
  EXPECT_TRUE(backlog.images().empty());
  for (int stamp = 2; stamp <= 4; ++stamp) backlog.add(image(stamp));
  EXPECT_EQ(backlog.images().size(), 3u) << "what was cleared takes no room";
}

TEST(ImageBacklog, MayKeepNothing) {
  ImageBacklog backlog(0);
  backlog.add(image(1));
  EXPECT_TRUE(backlog.images().empty());
}

}  // namespace
}  // namespace slamfuse::visual_slam
