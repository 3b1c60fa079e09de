// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <mrpt/io/CStream.h>
#include <zlib.h>

namespace slamfuse::laser_slam {

/// What an MRPT stream must have besides reading or writing, for one that only goes forward: seeking throws.
class ForwardStream : public mrpt::io::CStream {
 public:
  std::size_t Read(void* buffer, std::size_t count) override;
  std::size_t Write(const void* buffer, std::size_t count) override;
  std::uint64_t Seek(std::int64_t offset, TSeekOrigin origin) override;
  std::uint64_t getTotalBytesCount() const override { return position_; }
  std::uint64_t getPosition() const override { return position_; }

 protected:
  std::uint64_t position_ = 0;  ///< bytes read or written so far, uncompressed
};

/// Compresses what is written to it (zlib format, RFC 1950) and appends it to a string; holds 64 KiB and zlib's 256 KiB
/// besides. What is compressed is whole only after finish().
class DeflateStream : public ForwardStream {
 public:
  /// The string must outlive the stream.
  explicit DeflateStream(std::string& target);
  ~DeflateStream() override { deflateEnd(&state_); }
  DeflateStream(const DeflateStream&) = delete;
  DeflateStream& operator=(const DeflateStream&) = delete;

  std::size_t Write(const void* buffer, std::size_t count) override;
  void finish();

 private:
  void deflate_input(int flush);

  std::string& target_;
  z_stream state_{};
  std::array<char, 1 << 16> buffer_{};
};

/// Reads what a DeflateStream wrote. Reading throws std::runtime_error when the data is cut or is no zlib data; memory
/// does not depend on their length.
class InflateStream : public ForwardStream {
 public:
  /// The bytes must outlive the stream.
  explicit InflateStream(std::string_view compressed);
  ~InflateStream() override { inflateEnd(&state_); }
  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;

  std::size_t Read(void* buffer, std::size_t count) override;
  /// Whether what was read was all, with zlib's own checksum.
  bool at_end();

 private:
  std::size_t inflate_some(Bytef* target, std::size_t count);

  std::string_view rest_;  // not handed to zlib yet
  z_stream state_{};
  bool ended_ = false;
};

}  // namespace slamfuse::laser_slam
