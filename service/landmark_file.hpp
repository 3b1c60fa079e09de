// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"
#include "common/landmark.hpp"

namespace slamfuse::service {

/// Visual landmarks with their descriptors as bytes, all numbers little-endian:
///
///     "SFLANDMK"  8 bytes
///     version     u32, 3
///     length      u64, of the payload
///     crc32       u32, of the payload
///     payload     u64 count, then for each: id i64, position 3 x f64, covariance 9 x f64 (row by row), gray u8,
///                 observations i32, descriptor length u32, descriptor, known object's name length u32, name,
///                 count of views u32, then for each: direction 3 x f64, descriptor length u32, descriptor, patch
///                 length u32, patch
std::string landmarks_to_bytes(const std::vector<common::Landmark>& landmarks);

/// Reads them back, the same to the last bit; also versions 1 and 2, which have no views
/// and, the first, no names of objects. Errors (kInvalidInput): not such a
/// file, cut, altered, too long, or of a newer version. Never allocates more than a small multiple of the bytes given.
common::Result<std::vector<common::Landmark>> landmarks_from_bytes(std::string_view bytes);

}  // namespace slamfuse::service
