// SPDX-License-Identifier: BSD-3-Clause
#include "common/png_decoder.hpp"

#include <png.h>

#include <array>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>

namespace slamfuse::common {
namespace {

/// What libpng's callbacks share: the data still to read and the first error.
struct Progress {
  std::span<const std::uint8_t> rest;
  std::array<char, 160> error{};
};

[[noreturn]] void take_error(png_structp png, png_const_charp message) {
  auto* const progress = static_cast<Progress*>(png_get_error_ptr(png));
  std::snprintf(progress->error.data(), progress->error.size(), "%s", message);
  png_longjmp(png, 1);
}

/// libpng warns about odd colour profiles and the like; damage to the picture itself is an error.
void drop_warning(png_structp, png_const_charp) {}

void take_bytes(png_structp png, png_bytep target, png_size_t count) {
  auto* const progress = static_cast<Progress*>(png_get_io_ptr(png));
  if (count > progress->rest.size()) png_error(png, "the data ends early");
  std::memcpy(target, progress->rest.data(), count);
  progress->rest = progress->rest.subspan(count);
}

/// The part in which libpng may jump back: nothing with a destructor lives here.
bool read_gray_rows(png_structp png, png_infop info, png_bytepp rows, std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_info(png, info);
  png_set_strip_16(png);
  png_set_expand(png);
  png_set_strip_alpha(png);
  if ((png_get_color_type(png, info) & PNG_COLOR_MASK_COLOR) != 0) {
    png_set_rgb_to_gray_fixed(png, PNG_ERROR_ACTION_NONE, PNG_RGB_TO_GRAY_DEFAULT, PNG_RGB_TO_GRAY_DEFAULT);
  }
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) png_error(png, "rows of an unexpected size");
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kSignature = 8;
  return bytes.size() >= kSignature && png_sig_cmp(bytes.data(), 0, kSignature) == 0;
}

Result<ImageSize> png_size(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kWidthAt = 16;  // behind the signature, the length and the name of the head chunk
  constexpr std::size_t kHeightAt = 20;
  if (bytes.size() < kHeightAt + 4) return invalid_input("cut PNG");
  const png_uint_32 width = png_get_uint_32(bytes.data() + kWidthAt);
  const png_uint_32 height = png_get_uint_32(bytes.data() + kHeightAt);
  constexpr auto kMost = static_cast<png_uint_32>(std::numeric_limits<int>::max());
  if (width > kMost || height > kMost) return invalid_input("garbled PNG: impossible size");
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<std::vector<std::uint8_t>> decode_png(std::span<const std::uint8_t> bytes, ImageSize size) {
  Progress progress{bytes, {}};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &progress, take_error, drop_warning);
  if (png == nullptr) return failed("the PNG decoder cannot be started");
  png_infop info = png_create_info_struct(png);
  png_set_read_fn(png, &progress, take_bytes);

  const auto width = static_cast<std::size_t>(size.width);
  std::vector<std::uint8_t> pixels(width * static_cast<std::size_t>(size.height));
  std::vector<png_bytep> rows;
  for (std::size_t at = 0; at < pixels.size(); at += width) rows.push_back(pixels.data() + at);
  const bool complete = info != nullptr && read_gray_rows(png, info, rows.data(), width);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!complete) return invalid_input(std::string("cut or garbled PNG: ") + progress.error.data());
  return pixels;
}

}  // namespace slamfuse::common
