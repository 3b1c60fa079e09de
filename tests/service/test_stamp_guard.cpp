// SPDX-License-Identifier: BSD-3-Clause
#include "service/stamp_guard.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using Kind = StampGuard::Kind;
using testing::HasSubstr;

constexpr common::Nanoseconds kSecond = common::kNanosecondsPerSecond;
constexpr common::Nanoseconds kStart = 1'700'000'000 * kSecond;
const StampGuard::Arrival kNow{};

TEST(StampGuard, TakesRisingStampsOfEverySensor) {
  StampGuard guard;
  EXPECT_EQ(guard.judge("laser0", kStart, kNow).kind, Kind::kGood);
  EXPECT_EQ(guard.judge("odom0", kStart - kSecond, kNow).kind, Kind::kGood);
  EXPECT_EQ(guard.judge("laser0", kStart + 1, kNow).kind, Kind::kGood);
}

TEST(StampGuard, RefusesOneThatRepeatsOrStepsBack) {
  StampGuard guard;
  guard.judge("laser0", kStart, kNow);
  const auto repeats = guard.judge("laser0", kStart, kNow);
  EXPECT_EQ(repeats.kind, Kind::kRefused);
  EXPECT_THAT(repeats.reason, HasSubstr("repeats"));
  const auto back = guard.judge("laser0", kStart - kSecond, kNow);
  EXPECT_EQ(back.kind, Kind::kRefused);
  EXPECT_THAT(back.reason, HasSubstr("steps back by 1.000 s"));
  EXPECT_EQ(guard.judge("laser0", kStart + 1, kNow).kind, Kind::kGood);
}

TEST(StampGuard, OneGarbledStampDoesNotMakeTheNextOnesLate) {
  StampGuard guard;
  guard.judge("laser0", kStart, kNow);
  EXPECT_EQ(guard.judge("laser0", kStart + 3600 * kSecond, kNow).kind, Kind::kRefused);
  EXPECT_EQ(guard.judge("laser0", kStart + kSecond, kNow + 1s).kind, Kind::kGood);
}

// What a clock that was set by `by` leads to, and after how many messages at 10 Hz.
std::pair<Kind, int> after_a_jump(common::Nanoseconds by) {
  StampGuard guard;
  guard.judge("laser0", kStart, kNow);
  for (int i = 1; i < 100; ++i) {
    const auto verdict = guard.judge("laser0", kStart + by + i * kSecond / 10, kNow + i * 100ms);
    if (verdict.kind != Kind::kRefused) return {verdict.kind, i};
  }
  return {Kind::kRefused, 100};
}

TEST(StampGuard, FollowsAClockThatStaysAhead) {
  const auto [kind, messages] = after_a_jump(3600 * kSecond);
  EXPECT_EQ(kind, Kind::kClockJumped);
  EXPECT_LE(messages, 12);
}

TEST(StampGuard, WantsANewBeginningWhenAClockStaysBehind) {
  const auto [kind, messages] = after_a_jump(-3600 * kSecond);
  EXPECT_EQ(kind, Kind::kSteppedBack);
  EXPECT_LE(messages, 12);
}

TEST(StampGuard, ARepeatedOldStampIsNoNewTime) {
  StampGuard guard;
  guard.judge("laser0", kStart, kNow);
  for (int i = 1; i < 100; ++i) {
    EXPECT_EQ(guard.judge("laser0", kStart - kSecond, kNow + i * 100ms).kind, Kind::kRefused);
  }
}

}  // namespace
}  // namespace slamfuse::service
