// SPDX-License-Identifier: BSD-3-Clause
#include "service/rate_watch.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

// A topic looked at every second.
class Topic {
 public:
  // So many seconds with messages at this rate [1/s].
  void run(int seconds, double rate) {
    for (int i = 0; i < seconds; ++i) {
      now_ += 1s;
      received_ += rate;
      look();
    }
  }
  void look() { watch.look(now_, static_cast<std::size_t>(std::floor(received_ + 1e-9))); }

  RateWatch watch;

 private:
  RateWatch::Time now_ = RateWatch::Time() + 1h;
  double received_ = 0.0;
};

TEST(RateWatch, KnowsNothingBeforeFiveSeconds) {
  Topic topic;
  topic.look();
  topic.run(4, 10.0);
  EXPECT_FALSE(topic.watch.usual());
  EXPECT_FALSE(topic.watch.unusual());
  topic.run(1, 10.0);
  ASSERT_TRUE(topic.watch.usual());
  EXPECT_NEAR(*topic.watch.usual(), 10.0, 1e-9);
  EXPECT_NEAR(topic.watch.rate(), 10.0, 1e-9);
}

TEST(RateWatch, SilenceBeforeTheFirstMessageIsNoRate) {
  Topic topic;
  topic.look();
  topic.run(30, 0.0);
  topic.run(6, 20.0);
  EXPECT_NEAR(*topic.watch.usual(), 20.0, 1e-9);
}

// One message, silence, and then the driver runs.
TEST(RateWatch, AStutterAtTheStartIsNotUsual) {
  for (const int silence : {1, 3, 30}) {
    Topic topic;
    topic.look();
    topic.run(2, 1.0);
    topic.run(silence, 0.0);
    for (int second = 0; second < 60; ++second) {
      topic.run(1, 10.0);
      EXPECT_FALSE(topic.watch.unusual()) << second << " s after a silence of " << silence << " s";
    }
    ASSERT_TRUE(topic.watch.usual());
    EXPECT_NEAR(*topic.watch.usual(), 10.0, 2.0);
  }
}

TEST(RateWatch, SilenceWhileItLearnsDoesNotKeepItFromJudging) {
  Topic topic;
  topic.look();
  topic.run(3, 10.0);
  topic.run(600, 0.0);
  topic.run(10, 10.0);
  EXPECT_FALSE(topic.watch.unusual());
  topic.run(1, 1.0);
  EXPECT_TRUE(topic.watch.unusual());
}

TEST(RateWatch, SeesWithinASecondThatMessagesComeTenTimesAsFast) {
  Topic topic;
  topic.look();
  topic.run(10, 10.0);
  EXPECT_FALSE(topic.watch.unusual());
  topic.run(1, 100.0);
  ASSERT_TRUE(topic.watch.unusual());
  EXPECT_NEAR(*topic.watch.unusual(), 100.0, 1e-9);
  topic.run(1, 10.0);
  EXPECT_FALSE(topic.watch.unusual());
}

TEST(RateWatch, SeesWithinASecondThatATenthOfTheMessagesComes) {
  Topic topic;
  topic.look();
  topic.run(10, 10.0);
  topic.run(1, 1.0);
  ASSERT_TRUE(topic.watch.unusual());
  EXPECT_NEAR(*topic.watch.unusual(), 1.0, 1e-9);
}

TEST(RateWatch, HalfOrTwiceTheRateIsUsual) {
  Topic topic;
  topic.look();
  topic.run(10, 10.0);
  topic.run(5, 5.0);
  EXPECT_FALSE(topic.watch.unusual());
  topic.run(5, 20.0);
  EXPECT_FALSE(topic.watch.unusual());
}

TEST(RateWatch, ASlowTopicIsLookedAtForLonger) {
  Topic topic;
  topic.look();
  topic.run(20, 0.5);  // nothing, one, nothing, one
  ASSERT_TRUE(topic.watch.usual());
  for (int second = 0; second < 10; ++second) {
    topic.run(1, 0.5);
    EXPECT_FALSE(topic.watch.unusual());
  }
}

TEST(RateWatch, ATopicBelowAQuarterOfAHertzIsNotJudged) {
  Topic slow;
  slow.look();
  slow.run(60, 0.25);
  EXPECT_NEAR(*slow.watch.usual(), 0.25, 0.1);
  slow.run(20, 0.0);
  EXPECT_TRUE(slow.watch.unusual());
  Topic slower;
  slower.look();
  slower.run(120, 0.1);
  slower.run(60, 0.0);
  EXPECT_FALSE(slower.watch.unusual());
}

TEST(RateWatch, AChangeThatStaysIsToldForEver) {
  Topic topic;
  topic.look();
  topic.run(10, 10.0);
  topic.run(600, 1.0);
  EXPECT_TRUE(topic.watch.unusual());
}

TEST(RateWatch, LearnsAnewAfterAReset) {
  Topic topic;
  topic.look();
  topic.run(10, 10.0);
  topic.watch.reset();
  topic.look();
  topic.run(10, 1.0);
  EXPECT_NEAR(*topic.watch.usual(), 1.0, 1e-9);
  EXPECT_FALSE(topic.watch.unusual());
}

}  // namespace
}  // namespace slamfuse::service
