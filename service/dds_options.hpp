// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/options.hpp"
#include "idl/domain_settings.hpp"
#include "idl/ros_graph.hpp"

namespace slamfuse::service {

/// How `slamfuse run --dds` publishes. Times are of the wall clock: they bound the load on the network, not the content
/// of any file.
struct DdsOptions {
  idl::Network network = idl::Network::kLoopback;
  idl::RosGraph ros_graph = idl::RosGraph::kFromIron;
  std::string name_space;
  bool publish_tf = true;
  double reader_wait = 1.0;
  double linger = 2.0;
  double leave = 10.0;
  double map_period = 1.0;
  double path_period = 1.0;
  int path_poses = 1000;

  void describe(common::OptionVisitor& visit) {
    visit.choice("network", network, {{"loopback", idl::Network::kLoopback}, {"all", idl::Network::kAll}},
                 "Who may be met: programs of this machine that use loopback too (ROS_LOCALHOST_ONLY=1), or everybody "
                 "on the network. ROS_LOCALHOST_ONLY=1 narrows `all` to `loopback`.");
    visit.choice(
        "ros_graph", ros_graph,
        {{"iron", idl::RosGraph::kFromIron}, {"humble", idl::RosGraph::kUpToHumble}, {"none", idl::RosGraph::kNone}},
        "Shown as a node in ROS 2's graph: of Iron and later, of Humble and earlier (they differ), or not.");
    visit.text("namespace", name_space,
               "ROS 2 namespace of the node, of what it publishes (but tf and diagnostics), its services and "
               "initialpose, such as /laser: for several processes beside each other. Inputs are named by --topic.");
    visit.flag("publish_tf", publish_tf, "Publishes the transform map -> odom; off where another process does.");
    visit.real("reader_wait", reader_wait, {0.0, 60.0}, "s",
               "At most so long the run waits for somebody to listen before it starts.");
    visit.real("linger", linger, {0.0, 60.0}, "s",
               "At most so long the run waits at its end until every listener has everything.");
    visit.real(
        "leave", leave, {1.0, 600.0}, "s",
        "`serve`: when everything is saved and DDS hangs, the process ends with an error so long after `linger`.");
    visit.real("map_period", map_period, {0.5, 3600.0}, "s", "Least time between two maps; the last one always goes.");
    visit.real("path_period", path_period, {0.5, 3600.0}, "s",
               "Least time between two publications of a path; the last one always goes.");
    visit.integer("path_poses", path_poses, {2, 100000}, "poses",
                  "Longer paths are thinned evenly; 800 poses fill the 64 kB that arrive with default socket buffers.");
  }
};

}  // namespace slamfuse::service
