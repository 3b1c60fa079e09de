// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "common/ros_bag.hpp"

namespace slamfuse::common {

/// Numbers the topics of a bag, one to each name and type: a bag of several files, or recorders that came and went,
/// names the same topic again.
class TopicNumbers {
 public:
  const std::vector<RosTopic>& topics() const { return topics_; }
  /// The index into topics(). A type of ROS 2, "sensor_msgs/msg/LaserScan", becomes that of ROS 1.
  std::size_t number_of(RosTopic topic);

 private:
  std::vector<RosTopic> topics_;
};

}  // namespace slamfuse::common
