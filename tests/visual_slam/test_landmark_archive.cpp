// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/landmark_archive.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

constexpr common::Nanoseconds kSecond = 1'000'000'000;
constexpr int kManyKeyframes = 100;

/// A filter that drove 4 m along x and kept a pose each second and metre.
class LandmarkArchiveTest : public ::testing::Test {
 protected:
  LandmarkArchiveTest() {
    for (int second = 0; second <= 4; ++second) {
      if (second > 0) filter_.predict({1.0, Pose2{1.0, 0.0, 0.0}});
      filter_.add_keyframe(second * kSecond, kManyKeyframes);
    }
  }

  /// Enters a landmark that hangs on a keyframe and archives it, as seen last then.
  common::Landmark archive(LandmarkArchive& archive, LandmarkId id, common::Nanoseconds stamp, int observations = 5) {
    common::Landmark landmark;
    landmark.id = id;
    landmark.position = {2.0, 1.0, 0.5};
    landmark.observations = observations;
    filter_.add_point(id, landmark.position, *filter_.keyframe_at(stamp), kOwn);
    landmark.covariance = filter_.map_point(id)->covariance;
    gone_ = archive.add(filter_, landmark, stamp);
    filter_.remove(std::vector<LandmarkId>{id});
    return landmark;
  }

  const Eigen::Matrix3d kOwn = Eigen::Vector3d(1e-4, 2e-4, 3e-4).asDiagonal();
  Ekf filter_{{}, {}};
  std::optional<LandmarkId> gone_;
};

TEST_F(LandmarkArchiveTest, APlaceMovesAlongWithItsKeyframe) {
  LandmarkArchive archived(10);
  archive(archived, 1, 4 * kSecond);
  const Pose2 before = filter_.past_pose(*filter_.keyframe_at(4 * kSecond));

  filter_.correct_pose({4.2, 0.3, 0.1}, 1e-6 * Eigen::Matrix3d::Identity());

  const Pose2 motion = filter_.past_pose(*filter_.keyframe_at(4 * kSecond)) * before.inverse();
  const Eigen::Vector2d expected = motion * Eigen::Vector2d(2.0, 1.0);
  const std::vector<common::Landmark> now = archived.landmarks(filter_);
  ASSERT_EQ(now.size(), 1U);
  EXPECT_GT((expected - Eigen::Vector2d(2.0, 1.0)).norm(), 0.1);
  EXPECT_NEAR(now[0].position.x(), expected.x(), 1e-9);
  EXPECT_NEAR(now[0].position.y(), expected.y(), 1e-9);
  EXPECT_EQ(now[0].position.z(), 0.5);
}

TEST_F(LandmarkArchiveTest, ALandmarkThatReturnsHasTheErrorItLeftWith) {
  LandmarkArchive archived(10);
  const common::Landmark before = archive(archived, 1, 3 * kSecond);

  const ArchivedLandmark taken = archived.take(filter_, 1);
  filter_.add_point(1, taken.landmark.position, *filter_.keyframe_at(taken.keyframe), taken.relative_covariance);

  EXPECT_TRUE(filter_.map_point(1)->position.isApprox(before.position, 1e-12));
  EXPECT_TRUE(filter_.map_point(1)->covariance.isApprox(before.covariance, 1e-9));
  EXPECT_TRUE(taken.relative_covariance.isApprox(kOwn, 1e-6));
  EXPECT_EQ(taken.landmark.observations, 5);
  EXPECT_EQ(archived.size(), 0U);
}

TEST_F(LandmarkArchiveTest, HangsOnAnotherKeyframeWhenItsOwnIsGone) {
  LandmarkArchive archived(10);
  archive(archived, 1, 2 * kSecond);
  archived.follow(filter_);
  for (int second = 5; second < 40 && filter_.keyframe_at(2 * kSecond) != nullptr; ++second) {
    filter_.predict({1.0, Pose2{1.0, 0.0, 0.0}});
    filter_.add_keyframe(second * kSecond, 2);
    archived.follow(filter_);
  }
  ASSERT_EQ(filter_.keyframe_at(2 * kSecond), nullptr);

  const ArchivedLandmark taken = archived.take(filter_, 1);

  EXPECT_NE(filter_.keyframe_at(taken.keyframe), nullptr);
  EXPECT_TRUE(taken.landmark.position.isApprox(Eigen::Vector3d(2.0, 1.0, 0.5), 1e-6));
}

TEST_F(LandmarkArchiveTest, ThoseFoundLeastGoFirst) {
  LandmarkArchive archived(2);
  archive(archived, 1, kSecond, 9);
  archive(archived, 2, kSecond, 3);
  EXPECT_FALSE(gone_);
  archive(archived, 3, kSecond, 5);

  EXPECT_EQ(gone_, 2);
  EXPECT_EQ(archived.size(), 2U);
  EXPECT_FALSE(archived.contains(2));
}

}  // namespace
}  // namespace slamfuse::visual_slam
