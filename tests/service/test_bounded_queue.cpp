// SPDX-License-Identifier: BSD-3-Clause
#include "service/bounded_queue.hpp"

#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

TEST(BoundedQueue, HandsItemsOutInOrder) {
  BoundedQueue<int> queue(3);
  EXPECT_TRUE(queue.push(1));
  EXPECT_TRUE(queue.push(2));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), 2);
}

TEST(BoundedQueue, MakesTheProducerWaitForRoom) {
  BoundedQueue<int> queue(1);
  queue.push(0);
  std::jthread producer([&queue] { queue.push(1); });
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(queue.pop(), 0);
  EXPECT_EQ(queue.pop(), 1);
}

TEST(BoundedQueue, EndsAfterTheLastItemOnceClosed) {
  BoundedQueue<int> queue(2);
  queue.push(1);
  queue.close();
  EXPECT_FALSE(queue.push(2));
  EXPECT_EQ(queue.pop(), 1);
  EXPECT_EQ(queue.pop(), std::nullopt);
}

TEST(BoundedQueue, ForgetsItsItemsAndWakesTheWaitingWhenAborted) {
  BoundedQueue<int> queue(1);
  queue.push(1);
  std::jthread producer([&queue] { EXPECT_FALSE(queue.push(2)); });
  queue.abort();
  producer.join();
  EXPECT_EQ(queue.pop(), std::nullopt);
}

}  // namespace
}  // namespace slamfuse::service
