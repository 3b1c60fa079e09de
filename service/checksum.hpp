// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace slamfuse::service {

/// CRC-32 as in zip and PNG: finds accidents, not forgeries. `before` is that of the bytes in front of these.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace slamfuse::service
