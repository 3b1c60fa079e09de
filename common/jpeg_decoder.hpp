// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/image_size.hpp"

namespace slamfuse::common {

bool is_jpeg(std::span<const std::uint8_t> bytes);

/// The size that the head states. Error (kInvalidInput): damaged.
Result<ImageSize> jpeg_size(std::span<const std::uint8_t> bytes);

/// The luma channel, row-major; `size` is that of jpeg_size(). What the decoder would only warn about is an error: a
/// picture with a damaged stretch decodes to one that is partly grey or shifted.
Result<std::vector<std::uint8_t>> decode_jpeg(std::span<const std::uint8_t> bytes, ImageSize size);

}  // namespace slamfuse::common
