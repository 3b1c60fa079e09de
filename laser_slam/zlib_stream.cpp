// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/zlib_stream.hpp"

#include <algorithm>
#include <stdexcept>

namespace slamfuse::laser_slam {
namespace {

constexpr std::size_t kMostAtOnce = std::size_t{1} << 30;  // zlib counts in 32 bits

}  // namespace

std::size_t ForwardStream::Read(void*, std::size_t) { throw std::logic_error("a stream to write to"); }
std::size_t ForwardStream::Write(const void*, std::size_t) { throw std::logic_error("a stream to read from"); }
std::uint64_t ForwardStream::Seek(std::int64_t, TSeekOrigin) { throw std::logic_error("the stream only goes forward"); }

DeflateStream::DeflateStream(std::string& target) : target_(target) {
  if (deflateInit(&state_, Z_BEST_SPEED) != Z_OK) throw std::runtime_error("zlib cannot be started");
}

std::size_t DeflateStream::Write(const void* buffer, std::size_t count) {
  const auto* from = static_cast<const Bytef*>(buffer);
  std::size_t done = 0;
  while (done < count) {
    const std::size_t part = std::min(kMostAtOnce, count - done);
    state_.next_in = const_cast<Bytef*>(from + done);  // zlib only reads it
    state_.avail_in = static_cast<uInt>(part);
    deflate_input(Z_NO_FLUSH);
    done += part;
  }
  position_ += count;
  return count;
}

void DeflateStream::finish() { deflate_input(Z_FINISH); }

void DeflateStream::deflate_input(int flush) {
  do {
    state_.next_out = reinterpret_cast<Bytef*>(buffer_.data());
    state_.avail_out = static_cast<uInt>(buffer_.size());
    deflate(&state_, flush);
    target_.append(buffer_.data(), buffer_.size() - state_.avail_out);
  } while (state_.avail_out == 0);
}

InflateStream::InflateStream(std::string_view compressed) : rest_(compressed) {
  if (inflateInit(&state_) != Z_OK) throw std::runtime_error("zlib cannot be started");
}

std::size_t InflateStream::Read(void* buffer, std::size_t count) {
  std::size_t done = 0;
  while (done < count) {
    const std::size_t got = inflate_some(static_cast<Bytef*>(buffer) + done, std::min(kMostAtOnce, count - done));
    if (got == 0) throw std::runtime_error("the compressed data ends early");
    done += got;
  }
  position_ += count;
  return count;
}

bool InflateStream::at_end() {
  Bytef more = 0;
  return inflate_some(&more, 1) == 0 && ended_ && state_.avail_in == 0 && rest_.empty();
}

std::size_t InflateStream::inflate_some(Bytef* target, std::size_t count) {
  state_.next_out = target;
  state_.avail_out = static_cast<uInt>(count);
  while (state_.avail_out == count) {
    if (state_.avail_in == 0) {
      const std::size_t given = std::min(kMostAtOnce, rest_.size());
      state_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));  // zlib only reads it
      state_.avail_in = static_cast<uInt>(given);
      rest_.remove_prefix(given);
    }
    const int status = inflate(&state_, Z_NO_FLUSH);
    ended_ = status == Z_STREAM_END;
    if (ended_ || status == Z_BUF_ERROR) break;  // the latter: more input is needed and there is none
    if (status != Z_OK) throw std::runtime_error("the compressed data is garbled");
  }
  return count - state_.avail_out;
}

}  // namespace slamfuse::laser_slam
