// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace slamfuse::service {

/// CRC-32 as in zip and PNG: finds accidents, not forgeries.
std::uint32_t crc32_of(std::string_view bytes);

}  // namespace slamfuse::service
