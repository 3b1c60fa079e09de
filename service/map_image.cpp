// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_image.hpp"

#include <png.h>

#include <optional>
#include <span>
#include <string>

#include "common/image_decoder.hpp"
#include "common/png_decoder.hpp"
#include "service/bounded_file.hpp"

namespace slamfuse::service {
namespace {

constexpr std::uintmax_t kLargestFile = std::uintmax_t{64} << 20;

common::Result<MapImage> decode_map_png(std::span<const std::uint8_t> bytes, common::ImageSize size) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  MapImage image;
  bool good = png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) != 0;
  if (good) {
    png.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;  // the numbers as they are
    png.format &= PNG_FORMAT_FLAG_ALPHA | PNG_FORMAT_FLAG_COLOR;
    image.size = size;
    image.channels = PNG_IMAGE_PIXEL_CHANNELS(png.format);
    image.samples.resize(PNG_IMAGE_SIZE(png));
    good = png_image_finish_read(&png, nullptr, image.samples.data(), 0, nullptr) != 0;
  }
  png_image_free(&png);
  if (!good) return common::invalid_input(std::string("cut or garbled PNG: ") + png.message);
  return image;
}

common::Result<MapImage> decode(std::span<const std::uint8_t> bytes) {
  if (common::is_png(bytes)) {
    const auto size = common::stated_image_size(bytes);
    if (!size) return tl::unexpected(size.error());
    return decode_map_png(bytes, *size);
  }
  auto gray = common::decode_gray_image(bytes, std::nullopt);
  if (!gray) return tl::unexpected(gray.error());
  return MapImage{gray->size, 1, *gray->pixels};
}

}  // namespace

common::Result<MapImage> read_map_image(const std::filesystem::path& path) {
  const auto bytes = read_bounded(path, kLargestFile);
  if (!bytes) return tl::unexpected(bytes.error());
  auto image = decode({reinterpret_cast<const std::uint8_t*>(bytes->data()), bytes->size()});
  if (!image) return common::invalid_input(path.string() + ": " + image.error().message);
  return image;
}

}  // namespace slamfuse::service
