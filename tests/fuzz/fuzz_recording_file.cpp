// SPDX-License-Identifier: BSD-3-Clause
// Every recording that is one file, recognised by its content: CARMEN logs (plain, gzip, bzip2), rawlogs, ROS 1 bags,
// MCAP, SQLite. Opens it, reads it to the end, and its ground truth.
#include "common/recording.hpp"
#include "fuzz/scratch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slamfuse;
  const auto path = fuzz::write_scratch("recording", data, size);
  const auto recording = common::open_recording(path);
  if (!recording) return 0;
  while (true) {
    const auto item = (*recording)->next();
    if (!item || !*item) break;
  }
  static_cast<void>(common::read_ground_truth(path));
  return 0;
}
