// SPDX-License-Identifier: BSD-3-Clause
// A YAML file of options, and --set.
#include <string_view>

#include "common/config.hpp"
#include "fuzz/scratch_file.hpp"
#include "laser_slam/laser_slam_options.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slamfuse;
  laser_slam::LaserSlamOptions options;
  const auto describe = [&](common::OptionVisitor& visit) { visit.nested("laser", options, ""); };
  static_cast<void>(common::read_options(fuzz::write_scratch("options.yaml", data, size), describe));
  static_cast<void>(common::set_option({reinterpret_cast<const char*>(data), size}, describe));
  return 0;
}
