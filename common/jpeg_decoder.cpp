// SPDX-License-Identifier: BSD-3-Clause
#include "common/jpeg_decoder.hpp"

#include <turbojpeg.h>

#include <memory>
#include <string>
#include <type_traits>

namespace slamfuse::common {
namespace {

struct TurboJpegDeleter {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<std::remove_pointer_t<tjhandle>, TurboJpegDeleter>;

}  // namespace

bool is_jpeg(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

Result<ImageSize> jpeg_size(std::span<const std::uint8_t> bytes) {
  const TurboJpeg decoder(tjInitDecompress());
  if (!decoder) return failed("the JPEG decoder cannot be started");
  ImageSize size;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder.get(), bytes.data(), bytes.size(), &size.width, &size.height, &subsampling,
                          &colour_space) != 0) {
    return invalid_input(std::string("cut or garbled JPEG: ") + tjGetErrorStr2(decoder.get()));
  }
  return size;
}

Result<std::vector<std::uint8_t>> decode_jpeg(std::span<const std::uint8_t> bytes, ImageSize size) {
  const TurboJpeg decoder(tjInitDecompress());
  if (!decoder) return failed("the JPEG decoder cannot be started");
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  if (tjDecompress2(decoder.get(), bytes.data(), bytes.size(), pixels.data(), size.width, 0, size.height, TJPF_GRAY,
                    TJFLAG_STOPONWARNING) != 0) {
    return invalid_input(std::string("cut or garbled JPEG: ") + tjGetErrorStr2(decoder.get()));
  }
  return pixels;
}

}  // namespace slamfuse::common
