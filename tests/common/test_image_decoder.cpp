// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_decoder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "common/recording_samples.hpp"

namespace slamfuse::common {
namespace {

using namespace samples;
using ::testing::HasSubstr;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Result<GrayImage> decode(const std::string& text, std::optional<ImageSize> expected = ImageSize{16, 12}) {
  return decode_gray_image(bytes_of(text), expected);
}

TEST(ImageDecoder, DecodesEveryFormatToTheSameGray) {
  for (const char* extension : {".jpg", ".png", ".pgm"}) {
    const Result<GrayImage> image = decode(encoded_image(extension, 3));
    ASSERT_TRUE(image) << extension << image.error().message;
    ASSERT_EQ(image->pixels->size(), 16U * 12U);
    EXPECT_NEAR((*image->pixels)[16 * 2 + 3], 3 * 13 + 2 * 7 + 3 * 29, 12) << extension;
  }
}

TEST(ImageDecoder, TurnsColourIntoGray) {
  for (const char* extension : {".jpg", ".png", ".ppm"}) {
    const Result<GrayImage> image = decode(encoded_image(extension, 3, 16, 12, true));
    ASSERT_TRUE(image) << extension << image.error().message;
    EXPECT_NEAR((*image->pixels)[16 * 2 + 3], 3 * 13 + 2 * 7 + 3 * 29, 12) << extension;
  }
}

TEST(ImageDecoder, DecodesPlainPgmAndPpmWithCommentsAndAnyMaximum) {
  const auto pixels = [](const std::string& text) {
    const Result<GrayImage> image = decode(text, std::nullopt);
    return image ? *image->pixels : std::vector<std::uint8_t>{};
  };
  EXPECT_EQ(pixels("P2\n# made by hand\n3 1\n100\n0 50\n# and more\n100\n"), (std::vector<std::uint8_t>{0, 127, 255}));
  EXPECT_EQ(pixels("P2 2 1 255 7 999"), (std::vector<std::uint8_t>{7, 255}));
  EXPECT_EQ(pixels("P3 2 1 255 9 9 9 0 0 255"), (std::vector<std::uint8_t>{9, 29}));
  EXPECT_EQ(pixels("P5\n# binary\n2 1\n# white\n255\n\x07\xff"), (std::vector<std::uint8_t>{7, 255}));
  for (const char* bad :
       {"P2 3 1 255 1 2", "P2 3 1 255 1 2 x 4", "P2 3 1 255 1 -2 3", "P2 3 1 0 1 2 3", "P2 0 1 9 1"}) {
    EXPECT_FALSE(decode(bad, std::nullopt)) << bad;
  }
}

TEST(ImageDecoder, RefusesCutData) {
  for (const char* extension : {".jpg", ".png", ".pgm"}) {
    const std::string whole = encoded_image(extension, 1);
    for (const std::size_t size : {std::size_t{3}, std::size_t{10}, whole.size() / 2, whole.size() - 20}) {
      EXPECT_FALSE(decode(whole.substr(0, size))) << extension << " " << size;
    }
  }
}

TEST(ImageDecoder, RefusesGarbledJpegDataThatOtherDecodersWouldOnlyWarnAbout) {
  std::string bytes = encoded_image(".jpg", 1, 64, 64);
  const std::size_t middle = bytes.size() * 3 / 4;
  for (std::size_t i = 0; i < 12; ++i) bytes[middle + i] = static_cast<char>(0xFF);
  const Result<GrayImage> image = decode(bytes, std::nullopt);
  ASSERT_FALSE(image);
  EXPECT_THAT(image.error().message, HasSubstr("JPEG"));
}

TEST(ImageDecoder, RefusesOtherSizesThanExpected) {
  const Result<GrayImage> image = decode(encoded_image(".png", 1, 20, 12));
  ASSERT_FALSE(image);
  EXPECT_THAT(image.error().message, HasSubstr("20x12 pixels (expected: 16x12)"));
}

TEST(ImageDecoder, RefusesHugeStatedSizesBeforeTakingMemory) {
  EXPECT_FALSE(decode("P5\n2000000000 2000000000\n255\n", std::nullopt));
  EXPECT_FALSE(decode("P5\n99999999999999999999 2\n255\n", std::nullopt));
  std::string png = encoded_image(".png", 1);
  png[16] = '\x7F';
  EXPECT_FALSE(decode(png, std::nullopt));
}

TEST(ImageDecoder, RefusesWhatIsNoImage) {
  EXPECT_THAT(decode("").error().message, HasSubstr("empty"));
  EXPECT_THAT(decode("GIF89a....").error().message, HasSubstr("allowed: JPEG, PNG, PGM, PPM"));
  EXPECT_FALSE(decode("P5"));
  EXPECT_FALSE(decode("P5\n# only a comment"));
}

}  // namespace
}  // namespace slamfuse::common
