// SPDX-License-Identifier: BSD-3-Clause
#include "service/checksum.hpp"

#include <zlib.h>

namespace slamfuse::service {

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before) {
  const auto* data = reinterpret_cast<const Bytef*>(bytes.data());
  return static_cast<std::uint32_t>(::crc32_z(before, data, bytes.size()));
}

}  // namespace slamfuse::service
