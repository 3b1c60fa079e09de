// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/saved_map.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace slamfuse::visual_slam {
namespace {

std::vector<common::Landmark> map_of(int count) {
  std::vector<common::Landmark> map(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) map[static_cast<std::size_t>(i)].id = i;
  map.back().views.emplace_back();
  return map;
}

TEST(SavedMap, IsUsableWithOneLandmarkThatCanBeRecognised) { EXPECT_TRUE(check_saved_map(map_of(3))); }

TEST(SavedMap, IsRefusedWithTheReason) {
  std::vector<common::Landmark> nowhere = map_of(3), twice = map_of(3), unrecognisable = map_of(3);
  nowhere[1].position.x() = std::numeric_limits<double>::quiet_NaN();
  twice[1].id = 2;
  unrecognisable.back().views.clear();

  EXPECT_NE(check_saved_map(nowhere).error().message.find("landmark 1"), std::string::npos);
  EXPECT_NE(check_saved_map(twice).error().message.find("two landmarks"), std::string::npos);
  EXPECT_NE(check_saved_map(unrecognisable).error().message.find("none of its 3"), std::string::npos);
  EXPECT_FALSE(check_saved_map({}));
}

}  // namespace
}  // namespace slamfuse::visual_slam
