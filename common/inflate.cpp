// SPDX-License-Identifier: BSD-3-Clause
#include "common/inflate.hpp"

#include <algorithm>
#include <memory>
#include <optional>

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

namespace slamfuse::common {
namespace {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

constexpr std::size_t kStep = 1U << 20;  // bytes by which the result grows

Error no_memory() { return {ErrorKind::kInvalidInput, "no memory to decompress"}; }

/// Calls `step(place, room, stored)` until `size` bytes have come. It writes at most `room` bytes, moves `stored` on
/// and gives how many it wrote, nothing where the data are damaged.
template <class Step>
Result<Bytes> grow(const char* name, ByteView stored, std::size_t size, const Step& step) {
  Bytes bytes;
  while (bytes.size() < size) {
    const std::size_t before = bytes.size();
    const std::size_t left = stored.size();
    bytes.resize(std::min(size, before + kStep));
    const std::optional<std::size_t> made = step(bytes.data() + before, bytes.size() - before, stored);
    bytes.resize(before + made.value_or(0));
    if (!made || (*made == 0 && stored.size() == left)) break;
  }
  if (bytes.size() != size) return invalid_input(fmt::format("its {} data is damaged or ends early", name));
  return bytes;
}

Result<Bytes> inflate_bz2(ByteView stored, std::size_t size) {
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return tl::unexpected(no_memory());
  const std::unique_ptr<bz_stream, decltype(&BZ2_bzDecompressEnd)> guard(&stream, &BZ2_bzDecompressEnd);
  return grow("bz2", stored, size, [&](std::uint8_t* place, std::size_t room, ByteView& rest) {
    stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(rest.data()));  // bzlib does not write to it
    stream.avail_in = static_cast<unsigned>(rest.size());
    stream.next_out = reinterpret_cast<char*>(place);
    stream.avail_out = static_cast<unsigned>(room);
    const int code = BZ2_bzDecompress(&stream);
    rest = rest.last(stream.avail_in);
    const bool good = code == BZ_OK || code == BZ_STREAM_END;
    return good ? std::optional(room - stream.avail_out) : std::nullopt;
  });
}

Result<Bytes> inflate_lz4(ByteView stored, std::size_t size) {
  LZ4F_dctx* raw = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw, LZ4F_VERSION)) != 0) return tl::unexpected(no_memory());
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(raw,
                                                                                     &LZ4F_freeDecompressionContext);
  return grow("lz4", stored, size, [&](std::uint8_t* place, std::size_t room, ByteView& rest) {
    std::size_t made = room;
    std::size_t used = rest.size();
    const std::size_t code = LZ4F_decompress(context.get(), place, &made, rest.data(), &used, nullptr);
    rest = rest.subspan(used);
    return LZ4F_isError(code) == 0 ? std::optional(made) : std::nullopt;
  });
}

Result<Bytes> inflate_zstd(ByteView stored, std::size_t size) {
  const std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  if (!context) return tl::unexpected(no_memory());
  return grow("zstd", stored, size, [&](std::uint8_t* place, std::size_t room, ByteView& rest) {
    ZSTD_outBuffer out{place, room, 0};
    ZSTD_inBuffer in{rest.data(), rest.size(), 0};
    const std::size_t code = ZSTD_decompressStream(context.get(), &out, &in);
    rest = rest.subspan(in.pos);
    return ZSTD_isError(code) == 0 ? std::optional(out.pos) : std::nullopt;
  });
}

}  // namespace

Result<Bytes> inflate(const std::string& compression, ByteView stored, std::size_t size) {
  if (compression == "bz2") return inflate_bz2(stored, size);
  if (compression == "lz4") return inflate_lz4(stored, size);
  if (compression == "zstd") return inflate_zstd(stored, size);
  if (!compression.empty() && compression != "none") {
    return invalid_input("compression '" + compression + "' (known: none, bz2, lz4, zstd)");
  }
  if (stored.size() != size)
    return invalid_input(fmt::format("{} bytes are not the {} it tells of", stored.size(), size));
  return Bytes(stored.begin(), stored.end());
}

}  // namespace slamfuse::common
