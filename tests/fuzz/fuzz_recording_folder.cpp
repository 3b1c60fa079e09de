// SPDX-License-Identifier: BSD-3-Clause
// An EuRoC/ASL folder: the input is, separated by bytes of 255 (which text does not have), the laser's sensor.yaml and
// data.csv, the odometry's data.csv, the camera's sensor.yaml and data.csv, one picture and the reference's data.csv.
#include <algorithm>
#include <array>

#include "common/recording.hpp"
#include "fuzz/scratch_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slamfuse;
  constexpr std::array kFiles{"laser0/sensor.yaml",
                              "laser0/data.csv",
                              "odom0/data.csv",
                              "cam0/sensor.yaml",
                              "cam0/data.csv",
                              "cam0/data/1.png",
                              "state_groundtruth_estimate0/data.csv"};
  const std::uint8_t* const end = data + size;
  for (const char* file : kFiles) {
    const std::uint8_t* const stop = file == kFiles.back() ? end : std::find(data, end, std::uint8_t{255});
    fuzz::write_scratch(std::string("folder/") + file, data, static_cast<std::size_t>(stop - data));
    data = stop == end ? end : stop + 1;
  }
  const auto path = fuzz::scratch() / "folder";
  static_cast<void>(common::read_ground_truth(path));
  const auto recording = common::open_recording(path);
  if (!recording) return 0;
  while (true) {
    const auto item = (*recording)->next();
    if (!item || !*item) break;
  }
  return 0;
}
