// SPDX-License-Identifier: BSD-3-Clause
#include "common/image_decoder.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "common/jpeg_decoder.hpp"
#include "common/png_decoder.hpp"
#include "common/pnm_decoder.hpp"

namespace slamfuse::common {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Pixels = std::vector<std::uint8_t>;

constexpr std::int64_t kMostPixels = 64'000'000;
constexpr std::uintmax_t kLargestFile = std::uintmax_t{64} << 20;

struct Format {
  bool (*recognises)(Bytes);
  Result<ImageSize> (*size)(Bytes);
  Result<Pixels> (*decode)(Bytes, ImageSize);
};

Result<Format> format_of(Bytes bytes) {
  constexpr std::array<Format, 3> kFormats{
      {{is_jpeg, jpeg_size, decode_jpeg}, {is_png, png_size, decode_png}, {is_pnm, pnm_size, decode_pnm}}};
  const auto format =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.recognises(bytes); });
  if (format != kFormats.end()) return *format;
  return invalid_input(bytes.empty() ? "empty image file" : "not an image (allowed: JPEG, PNG, PGM, PPM)");
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

Result<ImageSize> checked_size(const Format& format, Bytes bytes) {
  Result<ImageSize> size = format.size(bytes);
  if (!size) return size;
  if (size->width < 1 || size->height < 1 || std::int64_t{size->width} * size->height > kMostPixels) {
    return invalid_input("image of " + text_of(*size) + " pixels (allowed: 1 to " + std::to_string(kMostPixels) + ")");
  }
  return size;
}

}  // namespace

Result<ImageSize> stated_image_size(std::span<const std::uint8_t> bytes) {
  const Result<Format> format = format_of(bytes);
  if (!format) return tl::unexpected(format.error());
  return checked_size(*format, bytes);
}

Result<GrayImage> decode_gray_image(std::span<const std::uint8_t> bytes, std::optional<ImageSize> expected) {
  const Result<Format> format = format_of(bytes);
  if (!format) return tl::unexpected(format.error());
  const Result<ImageSize> size = checked_size(*format, bytes);
  if (!size) return tl::unexpected(size.error());
  if (expected && *size != *expected) {
    return invalid_input("image of " + text_of(*size) + " pixels (expected: " + text_of(*expected) + ")");
  }
  Result<Pixels> pixels = format->decode(bytes, *size);
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
