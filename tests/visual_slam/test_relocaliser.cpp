// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/relocaliser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "common/angle.hpp"
#include "visual_slam/descriptor.hpp"
#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::Pose2;

/// A camera that drives along and shows noise, in which points of the world are what happens to be at their pixels.
class RelocaliserTest : public ::testing::Test {
 protected:
  struct Image {
    Glimpse glimpse;
    cv::Mat picture;
    std::vector<Eigen::Vector2d> features;
    std::vector<Eigen::Vector3d> points;
  };

  static Pose2 pose(int step) { return {-1.0 + 0.1 * step, 0.5, 0.3}; }
  /// What the wheels say: another frame.
  static Pose2 odometry(int step) { return Pose2{3.0, -2.0, 1.0} * pose(step); }

  /// The image taken at a step, of the points in view.
  Image look(int step) {
    testing::Noise noise(7 + static_cast<unsigned>(step));
    Image image;
    image.glimpse = {.stamp = common::Nanoseconds{step} * 100'000'000, .odometry = odometry(step), .camera = &camera_};
    image.picture = cv::Mat(480, 640, CV_8UC1);
    for (auto pixel = image.picture.begin<std::uint8_t>(); pixel != image.picture.end<std::uint8_t>(); ++pixel) {
      *pixel = static_cast<std::uint8_t>(255.0 * noise.uniform());
    }
    for (const Eigen::Vector3d& point : points_) {
      const auto projection = project_cartesian(camera_, Pose2{}, pose(step), point);
      const auto pixel = projection ? camera_.calibration.project(projection->point.homogeneous()) : std::nullopt;
      if (!pixel || !camera_.sees(*pixel, 25.0)) continue;
      image.features.push_back({std::round(pixel->x()), std::round(pixel->y())});
      image.points.push_back(point);
    }
    return image;
  }

  /// The landmarks an image shows, with their descriptors, brought to another place of the map.
  void map(const Image& image, const Pose2& elsewhere = {}) {
    const auto descriptors = describe(image.picture, image.features);
    for (std::size_t i = 0; i < descriptors.size(); ++i) {
      common::Landmark landmark;
      landmark.id = static_cast<std::int64_t>(map_.size()) + 1;
      landmark.position << elsewhere * Eigen::Vector2d(image.points[i].head<2>()), image.points[i].z();
      landmark.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      landmark.views.emplace_back().descriptor = descriptors[i];
      map_.push_back(landmark);
    }
  }

  std::optional<Relocalisation> find(Relocaliser& relocaliser, const std::vector<Image>& images) {
    const LandmarkIndex index(options_, map_);
    std::optional<Relocalisation> found;
    for (const Image& image : images) found = relocaliser.add(index, image.glimpse, image.picture, image.features);
    return found;
  }

  RelocalisationOptions options_;
  Camera camera_ = testing::make_camera("cam0", 0.3);
  std::vector<Eigen::Vector3d> points_ = [] {
    testing::Noise noise(3);
    return testing::room_points(150, noise);
  }();
  std::vector<common::Landmark> map_;
};

TEST_F(RelocaliserTest, FindsThePoseWhenImagesAgree) {
  const std::vector<Image> images{look(0), look(1), look(2)};
  for (const Image& image : images) map(image);
  for (const DescriptorSearch search : {DescriptorSearch::kComplete, DescriptorSearch::kFlann}) {
    options_.search = search;
    Relocaliser relocaliser(options_, 1);

    const std::optional<Relocalisation> found = find(relocaliser, images);

    ASSERT_TRUE(found);
    EXPECT_NEAR(found->pose.x, pose(2).x, 0.03);
    EXPECT_NEAR(found->pose.y, pose(2).y, 0.03);
    EXPECT_NEAR(common::normalize_angle(found->pose.theta - pose(2).theta), 0.0, 0.01);
    EXPECT_EQ(found->images, 3);
    EXPECT_GT(found->landmarks, 2 * found->runner_up);
    EXPECT_LT(std::sqrt(found->covariance(0, 0)), 0.05);
  }
}

TEST_F(RelocaliserTest, ClaimsNothingBeforeEnoughImagesAgree) {
  const std::vector<Image> images{look(0), look(1)};
  for (const Image& image : images) map(image);
  Relocaliser relocaliser(options_, 1);

  EXPECT_FALSE(find(relocaliser, images));
  EXPECT_TRUE(relocaliser.best());
}

TEST_F(RelocaliserTest, ClaimsNothingInAPlaceThatIsNotInTheMap) {
  for (const int step : {0, 1, 2}) map(look(step + 20));
  Relocaliser relocaliser(options_, 1);

  EXPECT_FALSE(find(relocaliser, {look(0), look(1), look(2)}));
}

TEST_F(RelocaliserTest, KeepsLookAlikePlacesApartUntilOneWins) {
  // The first images show what is in both of two places, one half here and the other half there; the last ones tell.
  std::vector<Image> images{look(0), look(1), look(2), look(3), look(4), look(5)};
  const Pose2 elsewhere{20.0, 0.0, 1.5};
  for (int i = 0; i < 3; ++i) {
    Image here = images[static_cast<std::size_t>(i)], there = here;
    const auto half = static_cast<std::ptrdiff_t>(here.features.size() / 2);
    here.features.erase(here.features.begin() + half, here.features.end());
    here.points.erase(here.points.begin() + half, here.points.end());
    there.features.erase(there.features.begin(), there.features.begin() + half);
    there.points.erase(there.points.begin(), there.points.begin() + half);
    map(here);
    map(there, elsewhere);
  }
  for (int i = 3; i < 6; ++i) map(images[static_cast<std::size_t>(i)], elsewhere);
  Relocaliser relocaliser(options_, 1);

  EXPECT_FALSE(find(relocaliser, {images[0], images[1], images[2]}));
  ASSERT_TRUE(relocaliser.best());
  EXPECT_GT(relocaliser.best()->runner_up, options_.min_landmarks);
  const std::optional<Relocalisation> found = find(relocaliser, {images[3], images[4], images[5]});

  ASSERT_TRUE(found);
  const Pose2 truth = elsewhere * pose(5);
  EXPECT_NEAR(found->pose.x, truth.x, 0.03);
  EXPECT_NEAR(found->pose.y, truth.y, 0.03);
}

TEST_F(RelocaliserTest, IsTheSameEachTime) {
  const std::vector<Image> images{look(0), look(1), look(2)};
  for (const Image& image : images) map(image);
  Relocaliser first(options_, 5), second(options_, 5);

  const auto a = find(first, images), b = find(second, images);

  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->pose.vector(), b->pose.vector());
  EXPECT_EQ(a->covariance, b->covariance);
}

TEST_F(RelocaliserTest, AnEmptyMapAndAnImageWithoutFeaturesAreNoTrouble) {
  Relocaliser relocaliser(options_, 1);

  EXPECT_FALSE(find(relocaliser, {look(0)}));
  map(look(0));
  Image empty = look(1);
  empty.features.clear();
  EXPECT_FALSE(find(relocaliser, {empty}));
}

}  // namespace
}  // namespace slamfuse::visual_slam
