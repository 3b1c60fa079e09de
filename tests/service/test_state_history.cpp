// SPDX-License-Identifier: BSD-3-Clause
#include "service/state_history.hpp"

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

constexpr auto kTracking = common::TrackingState::kTracking;
constexpr auto kUncertain = common::TrackingState::kUncertain;
constexpr auto kLost = common::TrackingState::kLost;

common::Nanoseconds at(double seconds) { return common::from_seconds(seconds); }

void expect_stretch(const StateStretch& stretch, double from, double to, common::TrackingState state) {
  EXPECT_EQ(stretch.from, at(from));
  EXPECT_EQ(stretch.to, at(to));
  EXPECT_EQ(stretch.state, state);
}

TEST(StateHistory, HoursInOneStateAreOneStretch) {
  StateHistory history;
  for (int i = 0; i < 100000; ++i) history.push(at(0.1 * i), kTracking);
  ASSERT_EQ(history.stretches().size(), 1U);
  expect_stretch(history.stretches().front(), 0.0, 9999.9 + 0.5, kTracking);
}

TEST(StateHistory, AnEstimateCountsUntilTheNextAndHalfASecondAtMost) {
  StateHistory history;
  history.push(at(1.0), kTracking);
  history.push(at(1.2), kUncertain);
  history.push(at(3.0), kUncertain);
  ASSERT_EQ(history.stretches().size(), 3U);
  expect_stretch(history.stretches()[0], 1.0, 1.2, kTracking);
  expect_stretch(history.stretches()[1], 1.2, 1.7, kUncertain);
  expect_stretch(history.stretches()[2], 3.0, 3.5, kUncertain);
}

TEST(StateHistory, AStampThatStepsBackCountsFromTheLastOneOn) {
  StateHistory history;
  history.push(at(1.0), kTracking);
  history.push(at(0.5), kUncertain);
  ASSERT_EQ(history.stretches().size(), 1U);
  expect_stretch(history.stretches()[0], 1.0, 1.5, kUncertain);
}

TEST(StateHistory, WhereThereAreTooManyStretchesNeighboursAreJoinedInTheWorseState) {
  StateHistory history(10);
  for (int i = 0; i < 1000; ++i) history.push(at(0.1 * i), i % 2 == 0 ? kTracking : kUncertain);
  history.push(at(100.0), kLost);
  for (int i = 1001; i < 1003; ++i) history.push(at(0.1 * i), kTracking);
  EXPECT_LE(history.stretches().size(), 11U);
  double lost = 0.0;
  for (const auto& stretch : history.stretches()) {
    if (stretch.state == kLost) lost += common::to_seconds(stretch.to - stretch.from);
  }
  EXPECT_GE(lost, 0.1);
  EXPECT_EQ(history.stretches().front().from, 0);
}

TEST(StateHistory, AHoleBetweenJoinedNeighboursIsALoss) {
  StateHistory history(2);
  for (const double seconds : {0.0, 10.0, 20.0}) history.push(at(seconds), kTracking);
  ASSERT_EQ(history.stretches().size(), 2U);
  expect_stretch(history.stretches()[0], 0.0, 10.5, kLost);
}

TEST(WithoutHoles, SilenceIsLostButForAMomentAtTheBeginning) {
  StateHistory history;
  history.push(at(1.4), kTracking);
  history.push(at(3.0), kTracking);
  const auto whole = without_holes(history.stretches(), at(1.0), at(5.0));
  ASSERT_EQ(whole.size(), 4U);
  expect_stretch(whole[0], 1.4, 1.9, kTracking);
  expect_stretch(whole[1], 1.9, 3.0, kLost);
  expect_stretch(whole[2], 3.0, 3.5, kTracking);
  expect_stretch(whole[3], 3.5, 5.0, kLost);
  EXPECT_EQ(without_holes(history.stretches(), at(0.0), at(5.0)).front().state, kLost) << "the first one came late";
  EXPECT_TRUE(without_holes({}, at(0.0), at(5.0)).empty());
}

TEST(WithoutHoles, CutsWhatLiesOutside) {
  StateHistory history;
  for (int i = 0; i < 100; ++i) history.push(at(0.1 * i), kTracking);
  const auto whole = without_holes(history.stretches(), at(2.0), at(4.0));
  ASSERT_EQ(whole.size(), 1U);
  expect_stretch(whole.front(), 2.0, 4.0, kTracking);
}

}  // namespace
}  // namespace slamfuse::service
