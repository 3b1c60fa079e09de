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
  EXPECT_TRUE(guard.take_insisted(kStart + 900ms).empty());
  const auto insisted = guard.take_insisted(kStart + 1s);
  ASSERT_TRUE(insisted.contains("cam0")) << "a camera may tell its calibration only once";
  EXPECT_EQ(insisted.at("cam0").k, calibration(600.0).k);
  EXPECT_FALSE(guard.doubts("cam0"));
  EXPECT_TRUE(guard.take_insisted(kStart + 2s).empty());
}

TEST(CalibrationGuard, TheKnownCalibrationInBetweenEndsTheDoubt) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.judge("cam0", calibration(500.0), calibration(500.0), kStart + 500ms);
  EXPECT_FALSE(guard.doubts("cam0"));
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart + 600ms);
  EXPECT_TRUE(guard.take_insisted(kStart + 1500ms).empty());
  EXPECT_FALSE(guard.take_insisted(kStart + 1600ms).empty());
}

TEST(CalibrationGuard, ACalibrationThatVariesIsNeverInsistedOn) {
  CalibrationGuard guard;
  auto now = kStart;
  for (int i = 0; i < 100; ++i, now += 100ms) {
    guard.judge("cam0", calibration(500.0), calibration(600.0 + i), now);
    EXPECT_TRUE(guard.take_insisted(now).empty());
  }
  guard.judge("cam0", calibration(500.0), calibration(700.0), now);
  guard.judge("cam0", calibration(500.0), calibration(700.0), now + 900ms);
  EXPECT_EQ(guard.take_insisted(now + 1s).at("cam0").k, calibration(700.0).k) << "it has come to rest";
}

TEST(CalibrationGuard, CamerasThatChangeTogetherInsistTogether) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.judge("cam1", calibration(500.0), calibration(610.0), kStart + 100ms);
  const auto insisted = guard.take_insisted(kStart + 1s);
  EXPECT_EQ(insisted.at("cam0").k, calibration(600.0).k);
  EXPECT_EQ(insisted.at("cam1").k, calibration(610.0).k);
}

TEST(CalibrationGuard, TheDoubtAboutOneCameraOutlastsTheChangeOfAnother) {
  CalibrationGuard guard;
  guard.judge("cam0", calibration(500.0), calibration(600.0), kStart);
  guard.judge("cam1", calibration(500.0), calibration(610.0), kStart + 800ms);
  EXPECT_EQ(guard.take_insisted(kStart + 1s).size(), 1u);
  EXPECT_TRUE(guard.doubts("cam1"));
  EXPECT_EQ(guard.take_insisted(kStart + 1800ms).count("cam1"), 1u);
}

}  // namespace
}  // namespace slamfuse::service
