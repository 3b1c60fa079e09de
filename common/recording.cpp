// SPDX-License-Identifier: BSD-3-Clause
#include "common/recording.hpp"

#include <string>
#include <system_error>

#include "common/euroc_recording.hpp"

namespace slamfuse::common {

Result<std::unique_ptr<Recording>> open_recording(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::exists(path, code)) return invalid_input(path.string() + ": no such file or folder");
  if (is_euroc_folder(path)) return open_euroc_recording(path);
  return invalid_input(path.string() + ": not a known recording");
}

Result<Trajectory2> read_ground_truth(const std::filesystem::path& path) {
  if (is_euroc_folder(path)) return read_euroc_ground_truth(path);
  return Trajectory2{};
}

}  // namespace slamfuse::common
