// SPDX-License-Identifier: BSD-3-Clause
#include "service/colmap_model.hpp"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/colmap_reader.hpp"

namespace slamfuse::service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Two cameras on a robot that has driven past some landmarks; the observations are exact.
class ColmapModelTest : public testing::Test {
 protected:
  void SetUp() override {
    common::CameraCalibration camera;
    camera.width = 640;
    camera.height = 480;
    camera.fx = 500.0;
    camera.fy = 510.0;
    camera.cx = 310.25;
    camera.cy = 239.5;
    camera.k1 = -0.2;
    camera.k2 = 0.05;
    camera.p1 = 0.001;
    camera.p2 = -0.002;
    cameras["left"] = camera;
    camera.k3 = 0.01;
    cameras["right"] = camera;
    for (int i = 0; i < 12; ++i) {
      common::Landmark landmark;
      landmark.id = 100 + i;
      landmark.position = {4.0 + 0.1 * i, std::sin(2.0 * i), 1.0 + 0.7 * std::cos(3.0 * i)};
      landmark.gray = static_cast<std::uint8_t>(20 * i);
      landmarks.push_back(landmark);
    }
    Eigen::Matrix3d forward;  // a camera that looks along x
    forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    for (int i = 0; i < 6; ++i) {
      common::Keyframe keyframe;
      keyframe.camera = i % 2 == 0 ? "left" : "right";
      keyframe.stamp = 1'000'000'000LL + i;
      keyframe.T_map_camera.translation = {0.2 * i, 0.1 * i, 1.0};
      keyframe.T_map_camera.rotation =
          Eigen::Quaterniond(Eigen::AngleAxisd(0.02 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix() * forward);
      for (const auto& landmark : landmarks) {
        const auto pixel = cameras[keyframe.camera].project(keyframe.T_map_camera.inverse() * landmark.position);
        ASSERT_TRUE(pixel);
        keyframe.observations.push_back({landmark.id, *pixel});
      }
      keyframes.push_back(keyframe);
    }
  }

  ColmapReader read() const {
    const ColmapModel model = colmap_model(cameras, keyframes, landmarks);
    return {model.cameras, model.images, model.points};
  }

  std::map<std::string, common::CameraCalibration> cameras;
  std::vector<common::Keyframe> keyframes;
  std::vector<common::Landmark> landmarks;
};

TEST_F(ColmapModelTest, PutsEveryPointWhereItWasSeen) {
  const ColmapReader model = read();

  const std::vector<double> errors = model.reprojection_errors();

  ASSERT_EQ(errors.size(), keyframes.size() * landmarks.size());
  EXPECT_LT(*std::max_element(errors.begin(), errors.end()), 2e-3);
  EXPECT_EQ(model.points.at(105).track.size(), keyframes.size());
  EXPECT_LT(model.points.at(105).error, 1e-6);
}

TEST_F(ColmapModelTest, NamesTheLensByItsDistortion) {
  cameras["right"].k1 = cameras["right"].k2 = cameras["right"].p1 = cameras["right"].p2 = cameras["right"].k3 = 0.0;

  const ColmapReader plain = read();
  cameras["right"].k3 = 0.01;
  const ColmapReader full = read();

  EXPECT_EQ(plain.cameras.at(1).model, "OPENCV");
  EXPECT_EQ(plain.cameras.at(2).model, "PINHOLE");
  EXPECT_THAT(plain.cameras.at(2).parameters, ElementsAre(500.0, 510.0, 310.75, 240.0))
      << "COLMAP's pixel centres are at halves";
  EXPECT_EQ(full.cameras.at(2).model, "FULL_OPENCV");
  EXPECT_EQ(full.cameras.at(2).parameters.size(), 12U);
}

TEST_F(ColmapModelTest, KeepsNamesNumbersAndBrightness) {
  const ColmapReader model = read();

  EXPECT_EQ(model.images.at(2).name, "right/1000000001.jpg");
  EXPECT_EQ(model.images.at(2).camera, 2);
  EXPECT_THAT(model.points.at(103).colour, ElementsAre(60, 60, 60));
  EXPECT_THAT(colmap_model(cameras, keyframes, landmarks).points, HasSubstr("frame visual_map"));
}

TEST_F(ColmapModelTest, LeavesOutObservationsOfLandmarksThatAreGone) {
  landmarks.erase(landmarks.begin());

  const ColmapReader model = read();

  EXPECT_FALSE(model.points.contains(100));
  EXPECT_EQ(model.images.at(1).points.size(), landmarks.size());
  EXPECT_EQ(model.reprojection_errors().size(), keyframes.size() * landmarks.size());
}

TEST_F(ColmapModelTest, KeepsLandmarksThatNoKeyframeShows) {
  common::Landmark lonely;
  lonely.id = 999;
  landmarks.push_back(lonely);

  const ColmapReader model = read();

  EXPECT_TRUE(model.points.at(999).track.empty());
  EXPECT_EQ(model.points.at(999).error, -1.0);
}

TEST_F(ColmapModelTest, AnImageWithoutPointsStillHasItsLine) {
  keyframes[0].observations.clear();

  const ColmapReader model = read();

  EXPECT_TRUE(model.images.at(1).points.empty());
  EXPECT_EQ(model.images.size(), keyframes.size());
}

}  // namespace
}  // namespace slamfuse::service
