// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/error.hpp"
#include "common/image_size.hpp"

namespace slamfuse::common {

/// Whether the data begins as a PGM or PPM: binary (P5, P6) or plain, its samples decimal text (P2, P3).
bool is_pnm(std::span<const std::uint8_t> bytes);

/// The size that the head states. Error (kInvalidInput): cut or garbled.
Result<ImageSize> pnm_size(std::span<const std::uint8_t> bytes);

/// The picture as 8 bit gray, row-major; `size` is that of pnm_size(). Values are scaled from the head's maximum to
/// 255, colour is weighed into gray (ITU-R BT.601). Error (kInvalidInput): cut or garbled.
Result<std::vector<std::uint8_t>> decode_pnm(std::span<const std::uint8_t> bytes, ImageSize size);

}  // namespace slamfuse::common
