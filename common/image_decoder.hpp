// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/image_size.hpp"

namespace slamfuse::common {

/// A decoded gray picture, row-major, one byte a pixel; shared so that an Image message can take it without a copy.
struct GrayImage {
  ImageSize size;
  std::shared_ptr<const std::vector<std::uint8_t>> pixels;
};

/// Decodes a whole image file held in memory: JPEG, PNG or PGM/PPM, known by their first bytes. Colour becomes gray
/// (for JPEG its luma channel), 16 bit becomes 8 bit. The size is read first and checked against `expected` (and
/// against 64 million pixels) before memory is taken. Errors (kInvalidInput), their text without the file's name: none
/// of these formats, wrong size, cut or garbled data. What a decoder would only warn about counts as garbled: a JPEG
/// with a damaged stretch decodes to a picture that is partly grey or shifted, which no consumer should see.
Result<GrayImage> decode_gray_image(std::span<const std::uint8_t> bytes, std::optional<ImageSize> expected);

/// The same for a file of at most 64 MiB; errors name the file.
Result<GrayImage> read_gray_image(const std::filesystem::path& path, std::optional<ImageSize> expected);

/// The size [px] that the head of an image file states. Errors as decode_gray_image.
Result<ImageSize> stated_image_size(std::span<const std::uint8_t> bytes);

}  // namespace slamfuse::common
