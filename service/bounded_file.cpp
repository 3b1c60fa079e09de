// SPDX-License-Identifier: BSD-3-Clause
#include "service/bounded_file.hpp"

#include <system_error>

#include <fmt/format.h>

namespace slamfuse::service {

namespace fs = std::filesystem;

common::Result<std::uintmax_t> open_bounded(const fs::path& path, std::uintmax_t limit, std::ifstream& file) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return common::invalid_input(path.string() + ": missing or not a file");
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size > limit) {
    return common::invalid_input(fmt::format("{}: {} bytes, at most {} are allowed", path.string(), size, limit));
  }
  file.open(path, std::ios::binary);
  if (!file) return common::invalid_input(path.string() + ": cannot be read");
  return size;
}

common::Result<std::string> read_bounded(const fs::path& path, std::uintmax_t limit) {
  std::ifstream file;
  const auto size = open_bounded(path, limit, file);
  if (!size) return tl::unexpected(size.error());
  std::string bytes(*size, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    return common::invalid_input(path.string() + ": cannot be read");
  }
  return bytes;
}

}  // namespace slamfuse::service
