// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "common/error.hpp"
#include "common/image_size.hpp"

namespace slamfuse::service {

/// The picture of a map with its transparency, eight bits a sample, row-major from the top.
struct MapImage {
  common::ImageSize size;
  std::size_t channels = 1;           ///< 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha (255 is opaque)
  std::vector<std::uint8_t> samples;  ///< pixel after pixel, `channels` each

  bool has_alpha() const { return channels == 2 || channels == 4; }
};

/// Reads a PNG of any kind (a palette becomes colours, its transparency and that of a single colour an alpha channel,
/// 16 bits become 8), a PGM or PPM (binary or plain) or a JPEG, which become gray. Errors (kInvalidInput, naming the
/// file): none of these, cut, garbled, more than 64 MiB or 64 million pixels.
common::Result<MapImage> read_map_image(const std::filesystem::path& path);

}  // namespace slamfuse::service
