// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "service/dds_options.hpp"
#include "service/external_poses.hpp"
#include "service/odometry_guard.hpp"

namespace slamfuse::service {

/// How the program connects the modules: the YAML section `service:`.
struct ServiceOptions {
  int command_delay = 16;
  int queue_capacity = 64;
  double map_interval = 2.0;
  int live_backlog = 16;
  double save_interval = 20.0;
  int live_history = 20000;
  OdometryLimits odometry;
  ExternalPoseOptions external_pose;
  DdsOptions dds;

  void describe(common::OptionVisitor& visit) {
    visit.integer("command_delay", command_delay, {1, 1000}, "messages",
                  "A command of the fusion takes effect this many messages after what caused it, always; larger lets "
                  "the modules run further ahead of each other. `serve`: with both halves one more than `live_backlog` "
                  "at least.");
    visit.integer("queue_capacity", queue_capacity, {1, 10000}, "messages",
                  "Messages that may wait for the fusion, and in `run` for a module; bounds the memory.");
    visit.real("map_interval", map_interval, {0.1, 3600.0}, "s",
               "Recording time between two pictures of the growing map.");
    visit.integer("live_backlog", live_backlog, {1, 10000}, "scans or images",
                  "`serve`: so many may wait for their module; more are dropped and counted.");
    visit.real("save_interval", save_interval, {1.0, 3600.0}, "s",
               "`serve`: time between two saves of the map; what came since the last is lost when it is killed.");
    visit.integer(
        "live_history", live_history, {100, 10000000}, "items",
        "`serve`: poses of each path, update times and rows of status.csv that are kept for the results; what "
        "is more is thinned evenly. Bounds the memory.");
    visit.nested("odometry", odometry, "`serve`: wheel odometry that is not believed.");
    visit.nested("external_pose", external_pose, "Poses of another SLAM system that come without a covariance.");
    visit.nested("dds", dds, "Publication as ROS 2 topics.");
  }
};

}  // namespace slamfuse::service
