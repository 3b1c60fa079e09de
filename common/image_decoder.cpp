// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_decoder.hpp"

#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Pixels = std::vector<std::uint8_t>;

constexpr std::int64_t kMostPixels = 64'000'000;
constexpr std::uintmax_t kLargestFile = std::uintmax_t{64} << 20;

enum class ImageFormat { kUnknown, kJpeg, kPng, kPnm };

bool starts_with(Bytes bytes, std::string_view magic) {
  return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

ImageFormat format_of(Bytes bytes) {
  if (starts_with(bytes, "\xFF\xD8\xFF")) return ImageFormat::kJpeg;
  if (starts_with(bytes, "\x89PNG\r\n\x1A\n")) return ImageFormat::kPng;
  if (starts_with(bytes, "P5") || starts_with(bytes, "P6")) return ImageFormat::kPnm;
  return ImageFormat::kUnknown;
}

struct TurboJpegDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<std::remove_pointer_t<tjhandle>, TurboJpegDeleter>;

Result<ImageSize> jpeg_size(Bytes bytes) {
  const TurboJpeg decoder(tjInitDecompress());
  if (!decoder) return failed("the JPEG decoder cannot be started");
  ImageSize size;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &size.width, &size.height, &subsampling,
                          &colour_space) != 0) {
    return invalid_input(std::string("damaged JPEG: ") + tjGetErrorStr2(decoder.get()));
  }
  return size;
}

Result<ImageSize> png_size(Bytes bytes) {
  constexpr std::size_t kWidthAt = 16;  // behind the signature, the length and the name of the IHDR chunk
  constexpr std::size_t kHeightAt = 20;
  if (bytes.size() < kHeightAt + 4) return invalid_input("cut PNG");
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | bytes[i];
    return value;
  };
  const std::uint32_t width = big_endian(kWidthAt);
  const std::uint32_t height = big_endian(kHeightAt);
  if (width > kMostPixels || height > kMostPixels) return invalid_input("damaged PNG: impossible size");
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<ImageSize> pnm_size(Bytes bytes) {
  // The head is "P5 width height maximum", blanks and "# comment" lines between them.
  std::size_t at = 2;
  const auto next_number = [&]() -> std::optional<std::int64_t> {
    while (at < bytes.size() && (std::isspace(bytes[at]) != 0 || bytes[at] == '#')) {
      if (bytes[at] == '#') {
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      } else {
        ++at;
      }
    }
    std::string digits;
    while (at < bytes.size() && std::isdigit(bytes[at]) != 0 && digits.size() < 10) {
      digits += static_cast<char>(bytes[at++]);
    }
    return parse_integer(digits);
  };
  const std::optional<std::int64_t> width = next_number();
  const std::optional<std::int64_t> height = next_number();
  if (!width || !height || *width > kMostPixels || *height > kMostPixels) return invalid_input("damaged PGM head");
  return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
}

Result<Pixels> decode_jpeg(Bytes bytes, ImageSize size) {
  const TurboJpeg decoder(tjInitDecompress());
  if (!decoder) return failed("the JPEG decoder cannot be started");
  Pixels pixels(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  if (tjDecompress2(decoder.get(), bytes.data(), bytes.size(), pixels.data(), size.width, 0, size.height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING) != 0) {
    return invalid_input(std::string("cut or garbled JPEG: ") + tjGetErrorStr2(decoder.get()));
  }
  return pixels;
}

Result<Pixels> decode_other(Bytes bytes, ImageSize size) try {
  // OpenCV takes a Mat head over the bytes and does not write to it.
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<std::uint8_t*>(bytes.data()));
  const cv::Mat image = cv::imdecode(encoded, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  if (image.empty()) return invalid_input("cut or garbled PNG or PGM");
  if (image.cols != size.width || image.rows != size.height || image.type() != CV_8UC1 || !image.isContinuous()) {
    return invalid_input("PNG or PGM that decodes to another size than its head states");
  }
  return Pixels(image.data, image.data + image.total());
} catch (const cv::Exception& error) {
  return invalid_input("cut or garbled PNG or PGM: " + error.err);
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

}  // namespace

Result<ImageSize> stated_image_size(std::span<const std::uint8_t> bytes) {
  Result<ImageSize> size;
  switch (format_of(bytes)) {
    case ImageFormat::kJpeg:
      size = jpeg_size(bytes);
      break;
    case ImageFormat::kPng:
      size = png_size(bytes);
      break;
    case ImageFormat::kPnm:
      size = pnm_size(bytes);
      break;
    case ImageFormat::kUnknown:
      return invalid_input(bytes.empty() ? "empty image file" : "not an image (allowed: JPEG, PNG, PGM, PPM)");
  }
  if (!size) return size;
  const std::int64_t count = std::int64_t{size->width} * size->height;
  if (size->width < 1 || size->height < 1 || count > kMostPixels) {
    return invalid_input("image of " + text_of(*size) + " pixels (allowed: 1 to " + std::to_string(kMostPixels) + ")");
  }
  return size;
}

Result<GrayImage> decode_gray_image(std::span<const std::uint8_t> bytes, std::optional<ImageSize> expected) {
  const Result<ImageSize> size = stated_image_size(bytes);
  if (!size) return tl::unexpected(size.error());
  if (expected && *size != *expected) {
    return invalid_input("image of " + text_of(*size) + " pixels (expected: " + text_of(*expected) + ")");
  }
  Result<Pixels> pixels =
      format_of(bytes) == ImageFormat::kJpeg ? decode_jpeg(bytes, *size) : decode_other(bytes, *size);
  if (!pixels) return tl::unexpected(pixels.error());
  return GrayImage{*size, std::make_shared<const Pixels>(std::move(*pixels))};
}

Result<GrayImage> read_gray_image(const std::filesystem::path& path, std::optional<ImageSize> expected) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return invalid_input(path.string() + ": no such file");
  const std::uintmax_t file_size = std::filesystem::file_size(path, code);
  if (code || file_size > kLargestFile) {
    return invalid_input(path.string() + ": image file of " + std::to_string(file_size) + " bytes (allowed: at most " +
                         std::to_string(kLargestFile) + ")");
  }
  Pixels bytes(static_cast<std::size_t>(file_size));
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    return invalid_input(path.string() + ": cannot be read");
  }
  Result<GrayImage> image = decode_gray_image(bytes, expected);
  if (!image) return invalid_input(path.string() + ": " + image.error().message);
  return image;
}

}  // namespace slamfuse::common
