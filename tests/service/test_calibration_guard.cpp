// SPDX-License-Identifier: BSD-3-Clause
#include "service/calibration_guard.hpp"

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

const CalibrationGuard::Arrival kStart = CalibrationGuard::Arrival() + 1h;

common::RosCameraInfo calibration(double focal_length) {
  common::RosCameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, 0.0, 0.0, 0.0, 0.0};
  info.k = {focal_length, 0.0, 320.0, 0.0, focal_length, 240.0, 0.0, 0.0, 1.0};
  return info;
}

TEST(CalibrationGuard, TheSameCalibrationWithAnotherStampIsTheSame) {
  CalibrationGuard guard;
  auto later = calibration(500.0);
  later.header.stamp = 7;
  later.header.frame = "another_name";
  EXPECT_TRUE(guard.judge("cam0", calibration(500.0), later, kStart));
  EXPECT_FALSE(guard.doubts("cam0"));
}

TEST(CalibrationGuard, EveryPartOfACalibrationCounts) {
  const auto known = calibration(500.0);
  auto other_size = known;
  other_size.width = 320;
  auto other_model = known;
  other_model.distortion_model = "equidistant";
  auto other_distortion = known;
  other_distortion.d[0] = 0.2;
  for (const auto& told : {other_size, other_model, other_distortion, calibration(501.0)}) {
    CalibrationGuard guard;
    EXPECT_FALSE(guard.judge("cam0", known, told, kStart));
    EXPECT_TRUE(guard.doubts("cam0"));
    EXPECT_FALSE(guard.doubts("cam1"));
  }
}

TEST(CalibrationGuard, ACameraInsistsWhenItTellsNothingElseForASecond) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  EXPECT_FALSE(guard.insisted_on("cam0", kStart + 900ms));
  EXPECT_FALSE(guard.insisted_on("cam1", kStart + 1s));
  const auto insisted = guard.insisted_on("cam0", kStart + 1s);
  ASSERT_TRUE(insisted) << "a camera may tell its calibration only once";
  EXPECT_EQ(insisted->k, calibration(600.0).k);
}

TEST(CalibrationGuard, TheKnownCalibrationInBetweenEndsTheDoubt) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.judge("cam0", calibration(500.0), calibration(500.0), kStart + 500ms);
  EXPECT_FALSE(guard.doubts("cam0"));
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart + 600ms);
  EXPECT_FALSE(guard.insisted_on("cam0", kStart + 1500ms));
  EXPECT_TRUE(guard.insisted_on("cam0", kStart + 1600ms));
}

TEST(CalibrationGuard, InsistsOnTheNewestOfSeveral) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.judge("cam0", calibration(500.0), calibration(700.0), kStart + 800ms);
  EXPECT_EQ(guard.insisted_on("cam0", kStart + 1s)->k, calibration(700.0).k);
}

TEST(CalibrationGuard, ForgetsItsDoubtsAfterAReset) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.reset();
  EXPECT_FALSE(guard.doubts("cam0"));
}

}  // namespace
}  // namespace slamfuse::service
