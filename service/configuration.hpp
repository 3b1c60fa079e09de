// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "fusion/fusion_options.hpp"
#include "laser_slam/laser_slam_options.hpp"
#include "service/service_options.hpp"
#include "visual_slam/options.hpp"

namespace slamfuse::service {

/// Every option of the program, as in its YAML files.
struct Configuration {
  laser_slam::LaserSlamOptions laser;
  visual_slam::VisualSlamOptions visual;
  fusion::FusionOptions fusion;
  ServiceOptions service;

  void describe(common::OptionVisitor& visit) {
    visit.nested("laser", laser, "Laser SLAM.");
    visit.nested("visual", visual, "Visual SLAM.");
    visit.nested("fusion", fusion, "Alignment of the two and the corrected pose.");
    visit.nested("service", service, "How the program connects the modules.");
  }
};

}  // namespace slamfuse::service
