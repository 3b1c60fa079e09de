// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/pose_estimate.hpp"
#include "idl/participant.hpp"
#include "idl/ros_namespace.hpp"
#include "idl/writer.hpp"
#include "service/dds_options.hpp"

namespace slamfuse::service {

/// The namespace the options name. Error (kInvalidInput): none that ROS allows.
common::Result<idl::RosNamespace> namespace_of(const DdsOptions& options);

/// The topics a run is published on (DESIGN section 7), names relative to a namespace but for `tf`. They outlive the
/// sessions of a service: listeners stay matched, and the last map stays to be had, while one session follows another.
struct DdsOutputs {
  idl::Writer<idl::PoseWithCovarianceStamped> pose;                 ///< slamfuse/pose
  std::optional<idl::Writer<idl::TFMessage>> transform;             ///< /tf; none when somebody else says map -> odom
  idl::Writer<idl::OccupancyGrid> map;                              ///< map
  idl::Writer<idl::PointCloud2> landmarks;                          ///< slamfuse/landmarks
  idl::Writer<idl::FusionStatus> status;                            ///< slamfuse/status
  std::map<common::PoseSource, idl::Writer<idl::Path>> paths = {};  ///< slamfuse/path/laser, visual and fused
  std::map<common::PoseSource, idl::Writer<idl::PoseWithCovarianceStamped>> initial_poses =
      {};  ///< what systems in the place of a half are told

  /// Error (kFailed): DDS makes no writer.
  static common::Result<std::shared_ptr<DdsOutputs>> create(const idl::Participant& participant,
                                                            const idl::RosNamespace& names, bool publish_tf);

  /// Adds the topic, with or without leading slash, on which the system in the place of a half is told its pose;
  /// nothing when it is empty. Error (kFailed): DDS makes no writer.
  common::Result<void> add_initial_pose(const idl::Participant& participant, common::PoseSource half,
                                        const std::string& topic);

  /// Waits, at most so long [s], until somebody listens to the pose and to tf.
  void wait_for_listeners(double seconds) const;
  /// Waits, at most so long [s], until every listener has everything.
  void wait_for_acknowledgments(double seconds) const;
};

}  // namespace slamfuse::service
