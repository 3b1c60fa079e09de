// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "idl/messages.hpp"

namespace slamfuse::service {

/// What a message takes in memory, nearly [bytes]: its large sequences and a little.
template <class T>
std::size_t memory_of(const T& /*message*/) {
  return sizeof(T);
}
inline std::size_t memory_of(const idl::Image& message) { return sizeof(message) + message.data._length; }
inline std::size_t memory_of(const idl::CompressedImage& message) { return sizeof(message) + message.data._length; }
inline std::size_t memory_of(const idl::LaserScan& message) {
  return sizeof(message) + sizeof(float) * (std::size_t{message.ranges._length} + message.intensities._length);
}
inline std::size_t memory_of(const idl::TFMessage& message) {
  return sizeof(message) + sizeof(idl::TransformStamped) * message.transforms._length;
}

}  // namespace slamfuse::service
