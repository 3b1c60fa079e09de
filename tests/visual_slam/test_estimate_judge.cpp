// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/estimate_judge.hpp"

#include <gtest/gtest.h>

namespace slamfuse::visual_slam {
namespace {

using common::kNanosecondsPerSecond;

constexpr ImageEvidence kGood{.expected = 30, .inliers = 25, .textured = true, .doubted = false};
constexpr ImageEvidence kElsewhere{.expected = 30, .inliers = 0, .textured = true, .doubted = false};

class EstimateJudgeTest : public ::testing::Test {
 protected:
  bool see(const ImageEvidence& evidence) {
    return judge_.judge(++seconds_ * kNanosecondsPerSecond, evidence, events_);
  }

  VisualSlamOptions options_;
  EstimateJudge judge_{options_};
  std::vector<common::Event> events_;
  int seconds_ = 0;
};

TEST_F(EstimateJudgeTest, TellsOnceThatItIsLostAndThatItIsBack) {
  EXPECT_FALSE(see(kGood));
  EXPECT_TRUE(judge_.is_tracking());
  int lost = 0;
  for (int i = 0; i < 5; ++i) lost += see(kElsewhere) ? 1 : 0;
  EXPECT_EQ(lost, 1);
  EXPECT_TRUE(judge_.is_lost());
  EXPECT_FALSE(judge_.map_may_grow());
  see(kGood);

  ASSERT_EQ(events_.size(), 2U);
  EXPECT_EQ(events_[0].kind, "lost");
  EXPECT_EQ(events_[0].module, "visual");
  EXPECT_EQ(events_[1].kind, "relocalised");
}

TEST_F(EstimateJudgeTest, WithoutWheelsAnImageContradictsNothing) {
  options_.motion.model = MotionModelKind::kConstantVelocity;
  judge_ = EstimateJudge(options_);
  see(kGood);
  judge_.judge(kNanosecondsPerSecond + 1, kElsewhere, events_);
  EXPECT_FALSE(judge_.is_lost());
  EXPECT_TRUE(judge_.map_may_grow());
}

TEST_F(EstimateJudgeTest, TellsOfALoopOnceAVisit) {
  const int enough = options_.recognition.loop_landmarks;
  judge_.tell_loop(enough - 1, kNanosecondsPerSecond, events_);
  EXPECT_TRUE(events_.empty());
  judge_.tell_loop(enough, 2 * kNanosecondsPerSecond, events_);
  judge_.tell_loop(enough, 3 * kNanosecondsPerSecond, events_);
  EXPECT_EQ(events_.size(), 1U);
  judge_.tell_loop(enough, 30 * kNanosecondsPerSecond, events_);
  EXPECT_EQ(events_.size(), 2U);
}

TEST_F(EstimateJudgeTest, TellsThatTheWheelsSlip) {
  const Ekf filter(options_.filter, options_.motion);
  const LandmarkBook book(options_);
  UpdateReport report;
  EXPECT_FALSE(judge_.doubts(filter, book, {}, report, 1, events_));
  report.wheels = SlipWatch::Verdict::kSlip;
  judge_.doubts(filter, book, {}, report, 2, events_);
  ASSERT_EQ(events_.size(), 1U);
  EXPECT_EQ(events_[0].kind, "wheel_slip");
  EXPECT_EQ(events_[0].stamp, 2);
}

}  // namespace
}  // namespace slamfuse::visual_slam
