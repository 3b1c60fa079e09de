// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_folder_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::HasSubstr;

class ImageFolderRecordingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file(folder_.path() / "sensor.yaml", kCameraYaml);
    for (const int i : {1, 2, 10}) {
      write_file(folder_.path() / ("img" + std::to_string(i) + ".png"), encoded_image(".png", i));
    }
    write_file(folder_.path() / "notes.txt", "not an image");
  }
  TemporaryFolder folder_;
};

TEST_F(ImageFolderRecordingTest, StampsImagesByRateInNaturalOrder) {
  const auto recording = open_recording(folder_.path());
  ASSERT_TRUE(recording) << recording.error().message;
  const Contents contents = read_all(**recording);

  EXPECT_EQ((*recording)->info().format, "images");
  EXPECT_EQ((*recording)->info().sensors.at("cam0").messages, 3U);
  EXPECT_EQ((*recording)->info().last_stamp, 400'000'000);
  ASSERT_EQ(contents.messages.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& image = std::get<Image>(contents.messages[i]);
    EXPECT_EQ(image.stamp, static_cast<Nanoseconds>(i) * 200'000'000);
    EXPECT_EQ((*image.pixels)[0], (i == 0 ? 1 : i == 1 ? 2 : 10) * 29 % 256);
  }
}

TEST_F(ImageFolderRecordingTest, RejectsABadImageAndKeepsItsPlaceInTime) {
  write_file(folder_.path() / "img2.png", "garbage");
  const Contents contents = open_and_read_all(folder_.path());
  ASSERT_EQ(contents.rejected.size(), 1U);
  EXPECT_EQ(contents.rejected[0].stamp, 200'000'000);
  EXPECT_THAT(contents.rejected[0].reason, HasSubstr("img2.png"));
  ASSERT_EQ(contents.messages.size(), 2U);
  EXPECT_EQ(stamp_of(contents.messages[1]), 400'000'000);
}

TEST_F(ImageFolderRecordingTest, RefusesAFolderWithoutRateOrWithoutImages) {
  const std::string yaml = kCameraYaml;
  const std::string rate = "rate_hz: 5\n";
  write_file(folder_.path() / "sensor.yaml", std::string(yaml).replace(yaml.find(rate), rate.size(), ""));
  EXPECT_THAT(open_recording(folder_.path()).error().message, HasSubstr("rate_hz is missing"));

  TemporaryFolder empty;
  write_file(empty.path() / "sensor.yaml", kCameraYaml);
  EXPECT_THAT(open_recording(empty.path()).error().message, HasSubstr("empty recording"));
}

}  // namespace
}  // namespace slamfuse::common
