// SPDX-License-Identifier: BSD-3-Clause
#include "service/durable_file.hpp"

#include <cerrno>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

tl::unexpected<common::Error> cannot(const char* action, const fs::path& path, int error) {
  return common::failed(fmt::format("cannot {} {}: {}", action, path.string(), std::generic_category().message(error)));
}

/// Closes on every way out.
class FileDescriptor {
 public:
  explicit FileDescriptor(int value) : value_(value) {}
  ~FileDescriptor() {
    if (value_ >= 0) ::close(value_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return value_; }
  /// Some file systems tell of a full disk only now.
  bool close() {
    const int closing = value_;
    value_ = -1;
    return ::close(closing) == 0;
  }

 private:
  int value_;
};

bool write_all(int file, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(file, content.data(), content.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

fs::path temporary_name(const fs::path& path) { return path.string() + ".partial"; }
/// A name that nobody else gives to anything.
fs::path old_name(const fs::path& path) { return path.string() + fmt::format(".slamfuse-old-{}", ::getpid()); }

}  // namespace

common::Result<void> write_durably(const fs::path& path, std::string_view content) {
  const fs::path temporary = temporary_name(path);
  FileDescriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return cannot("write", path, errno);
  if (!write_all(file.get(), content) || ::fsync(file.get()) != 0 || !file.close() ||
      ::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    return cannot("write", path, error);
  }
  return {};
}

common::Result<void> replace_path(const fs::path& from, const fs::path& to) {
  std::error_code error;
  const fs::path old = old_name(to);
  fs::remove_all(old, error);
  if (fs::is_directory(fs::symlink_status(to, error))) fs::rename(to, old, error);
  if (error && error != std::errc::no_such_file_or_directory) return cannot("replace", to, error.value());
  fs::rename(from, to, error);
  if (error) {
    std::error_code ignored;
    if (fs::exists(old, ignored)) fs::rename(old, to, ignored);
    return cannot("write", to, error.value());
  }
  fs::remove_all(old, error);
  return {};
}

common::Result<void> sync_folder(const fs::path& folder) {
  const FileDescriptor file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (file.get() < 0 || ::fsync(file.get()) != 0) return cannot("sync", folder, errno);
  return {};
}

}  // namespace slamfuse::service
