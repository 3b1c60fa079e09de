// SPDX-License-Identifier: BSD-3-Clause
#include "service/landmark_file.hpp"

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fusion/alignment.hpp"
#include "service/checksum.hpp"
#include "service/landmark_ply.hpp"

namespace slamfuse::service {
namespace {

using testing::HasSubstr;

std::vector<common::Landmark> two_landmarks() {
  common::Landmark first;
  first.id = -5;
  first.position = {1.0, 2.0, 0.5};
  first.covariance = Eigen::Matrix3d::Identity() * 1e-3;
  first.covariance(0, 2) = 1e-4;
  first.gray = 200;
  first.observations = 17;
  first.descriptor = {1, 2, 255};
  first.object = "poster";
  first.views = {{{1.0, 0.5, -0.25}, {3, 4}, {5, 6, 7}}, {{2.0, 0.0, 0.0}, {}, {}}};
  common::Landmark second;
  second.id = 1LL << 40;
  return {first, second};
}

TEST(LandmarkFile, ReadsBackTheSameToTheLastBit) {
  const auto landmarks = two_landmarks();
  const auto read = landmarks_from_bytes(landmarks_to_bytes(landmarks));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].id, landmarks[i].id);
    EXPECT_EQ((*read)[i].position, landmarks[i].position);
    EXPECT_EQ((*read)[i].covariance, landmarks[i].covariance);
    EXPECT_EQ((*read)[i].gray, landmarks[i].gray);
    EXPECT_EQ((*read)[i].observations, landmarks[i].observations);
    EXPECT_EQ((*read)[i].descriptor, landmarks[i].descriptor);
    EXPECT_EQ((*read)[i].object, landmarks[i].object);
    ASSERT_EQ((*read)[i].views.size(), landmarks[i].views.size());
    for (std::size_t view = 0; view < landmarks[i].views.size(); ++view) {
      EXPECT_EQ((*read)[i].views[view].direction, landmarks[i].views[view].direction);
      EXPECT_EQ((*read)[i].views[view].descriptor, landmarks[i].views[view].descriptor);
      EXPECT_EQ((*read)[i].views[view].patch, landmarks[i].views[view].patch);
    }
  }
}

TEST(LandmarkFile, HoldsNoLandmarkAtAll) {
  const auto read = landmarks_from_bytes(landmarks_to_bytes({}));
  ASSERT_TRUE(read.has_value());
  EXPECT_TRUE(read->empty());
}

TEST(LandmarkFile, RefusesEveryTruncation) {
  const std::string bytes = landmarks_to_bytes(two_landmarks());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(landmarks_from_bytes(bytes.substr(0, size)).has_value()) << size;
  }
}

TEST(LandmarkFile, RefusesEveryAlteredByte) {
  const std::string bytes = landmarks_to_bytes(two_landmarks());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string altered = bytes;
    altered[i] = static_cast<char>(altered[i] ^ 0x10);
    EXPECT_FALSE(landmarks_from_bytes(altered).has_value()) << i;
  }
}

TEST(LandmarkFile, RefusesBytesBehindTheEnd) {
  EXPECT_FALSE(landmarks_from_bytes(landmarks_to_bytes(two_landmarks()) + "x").has_value());
}

TEST(LandmarkFile, SaysThatANewerVersionIsNewer) {
  std::string bytes = landmarks_to_bytes({});
  bytes[8] = 4;
  EXPECT_THAT(landmarks_from_bytes(bytes).error().message, HasSubstr("version 4"));
}

TEST(LandmarkFile, ReadsTheVersionWithoutObjects) {
  // As version 1 wrote one landmark, id 7 at (1, 2, 0.5).
  std::string payload(8 + 8 + 12 * 8 + 1 + 4 + 4, '\0');
  payload[0] = 1;
  payload[8] = 7;
  for (int i = 0; i < 3; ++i) {
    const double value = std::vector<double>{1.0, 2.0, 0.5}[static_cast<std::size_t>(i)];
    std::memcpy(payload.data() + 16 + 8 * i, &value, sizeof value);
  }
  std::string bytes = landmarks_to_bytes({}).substr(0, 8);
  const auto append = [&bytes](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  append(std::uint32_t{1});
  append(static_cast<std::uint64_t>(payload.size()));
  append(crc32_of(payload));

  const auto read = landmarks_from_bytes(bytes + payload);

  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->size(), 1U);
  EXPECT_EQ(read->front().id, 7);
  EXPECT_EQ(read->front().position, Eigen::Vector3d(1.0, 2.0, 0.5));
  EXPECT_EQ(read->front().object, "");
}

TEST(LandmarkPly, StaysInTheVisualMapWithoutAnAlignment) {
  const std::string ply = landmarks_to_ply(two_landmarks(), {});
  EXPECT_THAT(ply, HasSubstr("frame visual_map"));
  EXPECT_THAT(ply, HasSubstr("comment object 1 poster\nelement vertex 2\n"));
  EXPECT_THAT(ply, HasSubstr("property int object\nend_header\n"));
  EXPECT_THAT(ply, HasSubstr("\n1.0000 2.0000 0.5000 200 200 200 1\n"));
}

TEST(LandmarkPly, BringsThePointsIntoTheLaserMapWithOne) {
  fusion::Alignment alignment;
  alignment.accepted = true;
  alignment.map.linear << 0.0, -2.0, 2.0, 0.0;
  alignment.map.translation = {10.0, 0.0};
  alignment.mean_scale = 2.0;
  alignment.mapping = fusion::to_mapping_matrix(alignment.map);
  const std::string ply = landmarks_to_ply(two_landmarks(), alignment);
  EXPECT_THAT(ply, HasSubstr("frame laser_map"));
  EXPECT_THAT(ply, HasSubstr("\n6.0000 2.0000 1.0000 200 200 200 1\n"));
}

}  // namespace
}  // namespace slamfuse::service
