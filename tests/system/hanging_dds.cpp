// SPDX-License-Identifier: BSD-3-Clause
// To be preloaded: dds_delete() never returns once the file that SLAMFUSE_HANG_WHEN names is there, as a Cyclone whose
// garbage collector is locked up.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

extern "C" __attribute__((visibility("default"))) std::int32_t dds_delete(std::int32_t entity) {
  const char* file = std::getenv("SLAMFUSE_HANG_WHEN");
  while (file != nullptr && access(file, F_OK) == 0) pause();
  using Delete = std::int32_t (*)(std::int32_t);
  static const auto real = reinterpret_cast<Delete>(dlsym(RTLD_NEXT, "dds_delete"));
  return real(entity);
}
