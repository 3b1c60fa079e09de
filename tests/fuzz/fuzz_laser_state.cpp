// SPDX-License-Identifier: BSD-3-Clause
// laser_state.bin of a map bundle, restored and used for a scan.
#include <string>

#include "laser_slam/laser_slam.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slamfuse;
  laser_slam::LaserSlamOptions options;
  options.particles = 2;
  common::LaserCalibration laser;
  laser.beams = 8;
  laser.angle_min = -1.0;
  laser.angle_increment = 0.25;
  laser.range_min = 0.1;
  laser.range_max = 10.0;
  const auto slam = laser_slam::LaserSlam::create(options, "laser0", laser, 1, 1);
  if (!slam) __builtin_trap();
  if (!(*slam)->restore({reinterpret_cast<const char*>(data), size})) return 0;
  (*slam)->process(common::LaserScan{1'000'000'000, "laser0", std::vector<float>(8, 2.0F)});
  static_cast<void>((*slam)->grid());
  return 0;
}
