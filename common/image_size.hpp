// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace slamfuse::common {

/// The size of a picture.
struct ImageSize {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  bool operator==(const ImageSize&) const = default;
};

}  // namespace slamfuse::common
