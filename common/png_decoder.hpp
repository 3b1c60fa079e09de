// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/image_size.hpp"

namespace slamfuse::common {

bool is_png(std::span<const std::uint8_t> bytes);

/// The size that the head states. Error (kInvalidInput): cut or impossible.
Result<ImageSize> png_size(std::span<const std::uint8_t> bytes);

/// The picture as 8 bit gray, row-major; `size` is that of png_size(). Colour is weighed into gray, the upper half of
/// 16 bit is taken, transparency is dropped. Error (kInvalidInput): cut or garbled, by the format's own checksums.
Result<std::vector<std::uint8_t>> decode_png(std::span<const std::uint8_t> bytes, ImageSize size);

}  // namespace slamfuse::common
