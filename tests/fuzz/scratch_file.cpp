// SPDX-License-Identifier: BSD-3-Clause
#include "fuzz/scratch_file.hpp"

#include <cstdlib>
#include <fstream>

#include <unistd.h>

namespace slamfuse::fuzz {

namespace fs = std::filesystem;

const fs::path& scratch() {
  static const fs::path kFolder = [] {
    const fs::path memory = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    const fs::path folder = memory / ("slamfuse-fuzz-" + std::to_string(::getpid()));
    fs::create_directories(folder);
    std::atexit([] { fs::remove_all(scratch()); });
    return folder;
  }();
  return kFolder;
}

fs::path write_scratch(const std::string& name, const std::uint8_t* data, std::size_t size) {
  const fs::path path = scratch() / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

}  // namespace slamfuse::fuzz
