// SPDX-License-Identifier: BSD-3-Clause
#include "common/byte_source.hpp"

#include <bzlib.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <utility>

namespace slamfuse::common {
namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

constexpr std::size_t kLargestRead = 1U << 20;  ///< keeps the int arguments of zlib and bzip2 in range

/// zlib reads files that are not gzip as they are, so this serves plain files too.
class GzipSource final : public ByteSource {
 public:
  GzipSource(gzFile file, std::string name) : file_(file), name_(std::move(name)) { gzbuffer(file_, 1U << 17); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;
  ~GzipSource() override { gzclose(file_); }

  Result<std::size_t> read(std::span<char> buffer) override {
    const int count = gzread(file_, buffer.data(), static_cast<unsigned>(std::min(buffer.size(), kLargestRead)));
    // A gzip file that ends early is reported with the last bytes or behind them, depending on where it was cut.
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (count > 0) return static_cast<std::size_t>(count);
    if (count == 0 && code == Z_OK) return std::size_t{0};
    if (code == Z_ERRNO) return invalid_input(name_ + ": cannot be read: " + std::strerror(errno));
    return invalid_input(name_ + ": its gzip data is damaged or ends early (" + text + ")");
  }

 private:
  gzFile file_;
  std::string name_;
};

class Bzip2Source final : public ByteSource {
 public:
  Bzip2Source(File file, std::string name) : file_(std::move(file)), name_(std::move(name)) { open_stream(); }
  Bzip2Source(const Bzip2Source&) = delete;
  Bzip2Source& operator=(const Bzip2Source&) = delete;
  ~Bzip2Source() override { close_stream(); }

  Result<std::size_t> read(std::span<char> buffer) override {
    const int wanted = static_cast<int>(std::min(buffer.size(), kLargestRead));
    while (stream_ != nullptr) {
      int code = BZ_OK;
      const int count = BZ2_bzRead(&code, stream_, buffer.data(), wanted);
      if (code == BZ_STREAM_END) {
        if (!open_next_stream()) return static_cast<std::size_t>(count);
      } else if (code != BZ_OK) {
        close_stream();
        damaged_ = true;
        break;
      }
      if (count > 0) return static_cast<std::size_t>(count);
    }
    if (damaged_) return invalid_input(name_ + ": its bzip2 data is damaged or ends early");
    return std::size_t{0};
  }

 private:
  void open_stream() {
    int code = BZ_OK;
    stream_ = BZ2_bzReadOpen(&code, file_.get(), 0, 0, unused_.data(), unused_size_);
    if (code != BZ_OK) close_stream();
  }

  void close_stream() {
    int code = BZ_OK;
    if (stream_ != nullptr) BZ2_bzReadClose(&code, stream_);
    stream_ = nullptr;
  }

  /// Parallel compressors write several streams one after the other. Returns false at the end of the file.
  bool open_next_stream() {
    int code = BZ_OK;
    void* rest = nullptr;
    int rest_size = 0;
    BZ2_bzReadGetUnused(&code, stream_, &rest, &rest_size);
    unused_size_ = code == BZ_OK ? rest_size : 0;
    if (unused_size_ > 0) std::memcpy(unused_.data(), rest, static_cast<std::size_t>(unused_size_));
    close_stream();
    if (unused_size_ == 0) {
      const int next = std::fgetc(file_.get());
      if (next == EOF) return false;
      std::ungetc(next, file_.get());
    }
    open_stream();
    return stream_ != nullptr;
  }

  File file_;
  std::string name_;
  BZFILE* stream_ = nullptr;
  bool damaged_ = false;
  std::array<char, BZ_MAX_UNUSED> unused_{};
  int unused_size_ = 0;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> open_byte_source(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) return invalid_input(path.string() + ": no such file");
  if (!std::filesystem::is_regular_file(status)) return invalid_input(path.string() + ": not a regular file");

  File file(std::fopen(path.c_str(), "rb"));
  if (!file) return invalid_input(path.string() + ": cannot be opened: " + std::strerror(errno));
  std::array<char, 3> magic{};
  const std::size_t magic_size = std::fread(magic.data(), 1, magic.size(), file.get());
  if (magic_size == magic.size() && std::memcmp(magic.data(), "BZh", magic.size()) == 0) {
    std::rewind(file.get());
    return std::make_unique<Bzip2Source>(std::move(file), path.string());
  }
  const gzFile gzip = gzopen(path.c_str(), "rb");
  if (gzip == nullptr) return invalid_input(path.string() + ": cannot be opened: " + std::strerror(errno));
  return std::make_unique<GzipSource>(gzip, path.string());
}

}  // namespace slamfuse::common
