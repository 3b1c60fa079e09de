// SPDX-License-Identifier: BSD-3-Clause
#include "common/thinned_history.hpp"

#include <algorithm>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

struct Item {
  Nanoseconds stamp = 0;
  int steps = 1;  // since the item before
};

struct AddSteps {
  void operator()(Item& next, const Item& gone) const { next.steps += gone.steps; }
};

using History = ThinnedHistory<Item, AddSteps>;
constexpr Nanoseconds kBlock = History::kBlock;

/// Items of a sensor, every `period`, `offset` after the full second.
History history_of(Nanoseconds period, int items, std::size_t most, Nanoseconds offset = 0) {
  History history(most);
  for (int i = 0; i < items; ++i) history.push({offset + i * period});
  return history;
}

std::set<Nanoseconds> blocks_of(const History& history) {
  std::set<Nanoseconds> blocks;
  for (const Item& item : history.items()) blocks.insert(item.stamp / kBlock);
  return blocks;
}

TEST(ThinnedHistory, KeepsAllWhileThereIsRoom) {
  EXPECT_EQ(history_of(kBlock / 10, 1000, 1000).items().size(), 1000u);
  EXPECT_EQ(history_of(kBlock / 10, 5000, kKeepAll).items().size(), 5000u);
}

TEST(ThinnedHistory, IsBoundedAndSpansTheWholeTimeInWholeBlocks) {
  constexpr std::size_t kMost = 1000;
  constexpr int kPerBlock = 20;
  for (const int end : {1001, 5000, 123456, 1000000}) {
    const History history = history_of(kBlock / kPerBlock, end, kMost);
    EXPECT_LE(history.items().size(), kMost);
    EXPECT_GE(history.items().size(), kMost / 2 - kPerBlock);
    EXPECT_EQ(history.count(), static_cast<std::size_t>(end));
    EXPECT_EQ(history.items().front().stamp, 0);
    EXPECT_EQ(history.items().back().stamp, (end - 1) * (kBlock / kPerBlock));
    const auto blocks = blocks_of(history);
    for (const Nanoseconds block : blocks) {
      if (block == *blocks.rbegin()) continue;  // it lasts
      EXPECT_EQ(std::ranges::count(history.items(), block, [](const Item& i) { return i.stamp / kBlock; }), kPerBlock);
    }
  }
}

TEST(ThinnedHistory, OfTwoSensorsTheSameBlocksAreKept) {
  const History fast = history_of(kBlock / 50, 200000, 2000);
  const History slow = history_of(kBlock / 7, 28000, 1500, kBlock / 100);
  const auto coarse = blocks_of(fast);
  const auto fine = blocks_of(slow);
  ASSERT_GT(coarse.size(), 15u);
  EXPECT_GT(fine.size(), coarse.size());
  EXPECT_TRUE(std::ranges::includes(fine, coarse));
}

TEST(ThinnedHistory, WhatGoesIsAbsorbedByTheNext) {
  for (const int end : {999, 1001, 20000, 54321}) {
    const History history = history_of(kBlock / 13, end, 1000);
    int steps = 0;
    for (const Item& item : history.items()) steps += item.steps;
    EXPECT_EQ(steps, end);
  }
}

TEST(ThinnedHistory, ABlockWithMoreThanFitsIsBoundedAndCostsTheOthersLittle) {
  History history = history_of(kBlock, 40, 100);
  for (int i = 0; i < 100000; ++i) history.push({40 * kBlock + i});
  EXPECT_LE(history.items().size(), 100u);
  EXPECT_EQ(history.items().back().stamp, 40 * kBlock + 99999);
  EXPECT_GE(blocks_of(history).size(), 20u);
  int steps = 0;
  for (const Item& item : history.items()) steps += item.steps;
  EXPECT_EQ(steps, 100040);
}

TEST(ThinnedHistory, StaysBoundedWhateverTheStamps) {
  History history(10);
  const Nanoseconds stamps[] = {5 * kBlock, 0, -3 * kBlock, 5 * kBlock, 5 * kBlock + 1, 0, 0, 4 * kBlock};
  for (int i = 0; i < 1000; ++i) {
    history.push({stamps[i % 8]});
    EXPECT_LE(history.items().size(), 10u);
    EXPECT_EQ(history.items().back().stamp, stamps[i % 8]);
  }
  History still(10);
  for (int i = 0; i < 1000; ++i) still.push({i % 2 * kBlock * (Nanoseconds{1} << 20)});
  EXPECT_LE(still.items().size(), 10u);
}

TEST(ThinnedHistory, BeginsAnew) {
  History history = history_of(kBlock / 10, 5000, 100);
  history.clear();
  EXPECT_TRUE(history.items().empty());
  for (int i = 0; i < 50; ++i) history.push({i * kBlock});
  EXPECT_EQ(history.items().size(), 50u);
}

TEST(ThinnedHistory, WhatSomethingHangsOnOutlivesItsBlockAsLongAsItDoes) {
  constexpr std::size_t kMost = 500;
  const auto every = [](int n) { return [n](const Item& item) { return item.stamp / (kBlock / 10) % n == 0; }; };
  const auto count = [&](const History& history, int n) { return std::ranges::count_if(history.items(), every(n)); };
  History history(kMost);
  for (int i = 0; i < 20000; ++i) history.push({i * (kBlock / 10)}, every(100));
  EXPECT_EQ(count(history, 100), 200);
  EXPECT_LE(history.items().size(), kMost + 200);
  for (int i = 20000; i < 80000; ++i) history.push({i * (kBlock / 10)}, every(1000));
  EXPECT_EQ(count(history, 1000), 80);
  EXPECT_LT(count(history, 100), 200);
  // Those that outlived take no other's place.
  EXPECT_GE(static_cast<int>(history.items().size()), static_cast<int>(kMost) / 2 - 20);
}

TEST(ThinnedHistory, WhatOutlivesMayBeMoreThanFits) {
  History history(10);
  for (int i = 0; i < 100; ++i) history.push({i * (kBlock / 10)}, [](const Item&) { return true; });
  EXPECT_EQ(history.items().size(), 100u);
  for (int i = 100; i < 200; ++i) history.push({i * (kBlock / 10)});
  EXPECT_LE(history.items().size(), 10u);
}

TEST(ThinnedHistory, TheNewestCanBeTakenAway) {
  History history = history_of(kBlock / 10, 15, 100);
  for (int i = 0; i < 8; ++i) history.pop();
  EXPECT_EQ(history.items().back().stamp, 6 * (kBlock / 10));
  for (int i = 7; i < 1000; ++i) history.push({i * (kBlock / 10)});
  EXPECT_LE(history.items().size(), 100u);
  EXPECT_EQ(history.items().front().stamp, 0);
}

}  // namespace
}  // namespace slamfuse::common
