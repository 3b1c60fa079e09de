// SPDX-License-Identifier: BSD-3-Clause
#include "service/durable_file.hpp"

#include <cerrno>
#include <cstdio>
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

common::Result<DurableFile> DurableFile::create(const fs::path& path) {
  const int file = ::open(temporary_name(path).c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) return cannot("write", path, errno);
  return DurableFile(path, file);
}

DurableFile::DurableFile(DurableFile&& other) noexcept
    : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

DurableFile::~DurableFile() {
  if (file_ < 0) return;
  close();
  ::unlink(temporary_name(path_).c_str());
}

bool DurableFile::close() { return ::close(std::exchange(file_, -1)) == 0; }

common::Result<void> DurableFile::append(std::string_view content) {
  if (!write_all(file_, content)) return cannot("write", path_, errno);
  return {};
}

common::Result<void> DurableFile::publish() {
  const std::string temporary = temporary_name(path_);
  // Some file systems tell of a full disk only when the file is closed.
  if (::fsync(file_) == 0 && close() && ::rename(temporary.c_str(), path_.c_str()) == 0) return {};
  const int error = errno;
  if (file_ < 0) ::unlink(temporary.c_str());
  return cannot("write", path_, error);
}

common::Result<void> write_durably(const fs::path& path, std::string_view content) {
  auto file = DurableFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto written = file->append(content); !written) return written;
  return file->publish();
}

common::Result<void> replace_path(const fs::path& from, const fs::path& to) {
  std::error_code error;
  // At no moment there is nothing under the name, so that a process killed here leaves the old or the new.
  if (fs::is_directory(fs::symlink_status(to, error)) &&
      ::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0) {
    fs::remove_all(from, error);
    return {};
  }
  error.clear();
  const fs::path old = old_name(to);  // for file systems that cannot exchange
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
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return cannot("sync", folder, errno);
  const bool synced = ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  if (!synced) return cannot("sync", folder, error);
  return {};
}

}  // namespace slamfuse::service
