// SPDX-License-Identifier: BSD-3-Clause
#include "service/command_path.hpp"

#include <atomic>
#include <chrono>
#include <thread>
#include <variant>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using common::PoseSource;

MergedStep step_at(SequenceIndex index) {
  MergedStep step;
  step.index = index;
  return step;
}

NumberedMessage input_at(SequenceIndex index) { return {index, common::WheelOdometry{}, std::nullopt}; }

TEST(CommandPath, LetsAModuleRunAheadOfTheFusionByTheDelayButNoFurther) {
  CommandPath path(3);
  EXPECT_TRUE(path.await(PoseSource::kLaser, input_at(2)).has_value());
  std::atomic<bool> passed{false};
  std::jthread module([&] {
    path.await(PoseSource::kLaser, input_at(3));
    passed = true;
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(passed);
  path.advance(0);
  module.join();
  EXPECT_TRUE(passed);
}

TEST(CommandPath, HandsACommandOutOnceToItsTargetAtTheFirstInputDue) {
  CommandPath path(2);
  path.issue(step_at(0), PoseSource::kLaser, common::Reset{});
  path.advance(9);
  EXPECT_TRUE(path.await(PoseSource::kLaser, input_at(1))->empty());
  EXPECT_TRUE(path.await(PoseSource::kVisual, input_at(5))->empty());
  EXPECT_EQ(path.await(PoseSource::kLaser, input_at(5))->size(), 1U);
  EXPECT_TRUE(path.await(PoseSource::kLaser, input_at(6))->empty());
}

TEST(CommandPath, KeepsTheOrderOfCommands) {
  CommandPath path(1);
  path.issue(step_at(0), PoseSource::kVisual, common::Reset{});
  path.issue(step_at(1), PoseSource::kVisual, common::Relocalise{});
  path.advance(1);
  const auto due = path.await(PoseSource::kVisual, input_at(2));
  ASSERT_EQ(due->size(), 2U);
  EXPECT_TRUE(std::holds_alternative<common::Reset>((*due)[0]));
  EXPECT_TRUE(std::holds_alternative<common::Relocalise>((*due)[1]));
}

TEST(CommandPath, WakesAWaitingModuleWhenAborted) {
  CommandPath path(1);
  std::jthread module([&] { EXPECT_FALSE(path.await(PoseSource::kLaser, input_at(10)).has_value()); });
  path.abort();
}

}  // namespace
}  // namespace slamfuse::service
