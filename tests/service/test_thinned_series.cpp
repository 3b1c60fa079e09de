// SPDX-License-Identifier: BSD-3-Clause
#include "service/thinned_series.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using testing::ElementsAre;

ThinnedSeries<int> counted_to(int end, std::size_t most) {
  ThinnedSeries<int> series(most);
  for (int i = 0; i < end; ++i) series.push(i);
  return series;
}

TEST(ThinnedSeries, KeepsAllWhileThereIsRoom) {
  EXPECT_THAT(counted_to(4, 4).items(), ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(counted_to(1000, ThinnedSeries<int>::kAll).items().size(), 1000u);
}

TEST(ThinnedSeries, HalvesWhenFullAndGoesOnEvenly) {
  EXPECT_THAT(counted_to(5, 4).items(), ElementsAre(0, 2, 4));
  EXPECT_THAT(counted_to(6, 4).items(), ElementsAre(0, 2, 4, 5));
  EXPECT_THAT(counted_to(7, 4).items(), ElementsAre(0, 2, 4, 6));
  EXPECT_THAT(counted_to(9, 4).items(), ElementsAre(0, 4, 8));
}

TEST(ThinnedSeries, IsBoundedEvenAndEndsWithTheNewest) {
  constexpr std::size_t kMost = 100;
  for (const int end : {101, 1000, 12345, 100000}) {
    const auto series = counted_to(end, kMost);
    const auto& items = series.items();
    EXPECT_LE(items.size(), kMost);
    EXPECT_GE(items.size(), kMost / 2);
    EXPECT_EQ(items.front(), 0);
    EXPECT_EQ(items.back(), end - 1);
    for (std::size_t i = 2; i + 1 < items.size(); ++i) EXPECT_EQ(items[i] - items[i - 1], items[1] - items[0]);
    EXPECT_EQ(series.count(), static_cast<std::size_t>(end));
  }
}

TEST(ThinnedSeries, BeginsAnew) {
  auto series = counted_to(50, 4);
  series.clear();
  EXPECT_TRUE(series.items().empty());
  series.push(1);
  series.push(2);
  EXPECT_THAT(series.items(), ElementsAre(1, 2));
}

}  // namespace
}  // namespace slamfuse::service
