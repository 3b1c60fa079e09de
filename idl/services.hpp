// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <slamfuse_srvs.h>
#include <std_srvs.h>

#include "idl/messages.hpp"

namespace slamfuse::idl {

/// std_srvs/srv/Trigger.
struct Trigger {
  using Request = std_srvs_srv_dds__Trigger_Request_;
  using Response = std_srvs_srv_dds__Trigger_Response_;
};
/// slamfuse_msgs/srv/SetMode: string mode -> bool success, string message.
struct SetMode {
  using Request = slamfuse_msgs_srv_dds__SetMode_Request_;
  using Response = slamfuse_msgs_srv_dds__SetMode_Response_;
};
/// slamfuse_msgs/srv/LoadMap: string path -> bool success, string message.
struct LoadMap {
  using Request = slamfuse_msgs_srv_dds__LoadMap_Request_;
  using Response = slamfuse_msgs_srv_dds__LoadMap_Response_;
};

template <>
inline const dds_topic_descriptor_t& descriptor<Trigger::Request>() {
  return std_srvs_srv_dds__Trigger_Request__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Trigger::Response>() {
  return std_srvs_srv_dds__Trigger_Response__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<SetMode::Request>() {
  return slamfuse_msgs_srv_dds__SetMode_Request__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<SetMode::Response>() {
  return slamfuse_msgs_srv_dds__SetMode_Response__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<LoadMap::Request>() {
  return slamfuse_msgs_srv_dds__LoadMap_Request__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<LoadMap::Response>() {
  return slamfuse_msgs_srv_dds__LoadMap_Response__desc;
}

}  // namespace slamfuse::idl
