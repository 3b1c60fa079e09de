// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "common/command.hpp"
#include "common/error.hpp"
#include "idl/messages.hpp"
#include "idl/participant.hpp"
#include "idl/ros_namespace.hpp"

namespace slamfuse::service {

/// What an operator may ask of a running service. Each gives what was done in words, or why it was not (any kind of
/// error). Called from one thread at a time.
class OperatorActions {
 public:
  using Answer = common::Result<std::string>;

  virtual ~OperatorActions() = default;
  virtual Answer save_map() = 0;
  virtual Answer load_map(const std::string& path) = 0;
  virtual Answer set_mode(const std::string& mode) = 0;
  virtual Answer align_now() = 0;
  virtual Answer relocalise() = 0;
  virtual Answer set_pose(const common::SetPose& pose) = 0;
};

/// Offers the actions over DDS: services `slamfuse/save_map`, `align_now`, `reinitialize_global_localization`
/// (std_srvs/srv/Trigger), `set_mode`, `load_map` (slamfuse_msgs/srv), and the topic `initialpose`, all in a namespace.
/// A thread of its own waits for all of them and carries out one after the other.
class OperatorServices {
 public:
  /// `actions` must outlive it; `tell` hears what was asked and answered, in the services' thread. Error (kFailed): DDS
  /// makes no endpoint.
  static common::Result<std::unique_ptr<OperatorServices>> start(const idl::Participant& participant,
                                                                 const idl::RosNamespace& names,
                                                                 OperatorActions& actions,
                                                                 const std::function<void(const std::string&)>& tell);

 private:
  OperatorServices() = default;
  std::jthread thread_;
};

/// What an `initialpose` asks for. Error (kInvalidInput): another frame than `map`, numbers that are not finite, no
/// rotation, a covariance that is none.
common::Result<common::SetPose> set_pose_of(const idl::PoseWithCovarianceStamped& message);

}  // namespace slamfuse::service
