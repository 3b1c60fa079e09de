// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

struct dds_qos;

namespace slamfuse::idl {

/// The settings of an endpoint, chosen so that it matches what ROS 2 nodes use on such topics.
enum class QosProfile {
  kSensorInput,           ///< scan, image, camera_info, odom: best effort, keep last 10 (matches reliable writers too)
  kTransformInput,        ///< tf: reliable, keep last 100
  kStaticTransformInput,  ///< tf_static: reliable, transient local, keep last 100
  kCommandInput,          ///< initialpose: reliable, keep last 10
  kOutput,                ///< pose, path, tf, status, diagnostics, landmarks: reliable, keep last 10
  kLatchedOutput,         ///< map: reliable, transient local, keep last 1; also for readers of it
};

struct DeleteQos {
  void operator()(dds_qos* qos) const;
};
using UniqueQos = std::unique_ptr<dds_qos, DeleteQos>;

/// The Cyclone settings of a profile. All use XCDR1 (a Fast DDS reader matches an XCDR2 writer and then receives
/// nothing), dispose nothing when a writer ends, and request neither deadline nor liveliness, which ROS does not offer.
UniqueQos make_qos(QosProfile profile);

/// Whether an endpoint's settings are reliable; where they say nothing they are not.
bool is_reliable(const dds_qos& qos);
/// Whether an endpoint's settings keep what was sent for those who come late (transient local or more).
bool is_transient_local(const dds_qos& qos);

/// The USER_DATA of an endpoint's or participant's settings, where ROS 2 keeps what DDS has no place for.
std::string user_data_of(const dds_qos& qos);

}  // namespace slamfuse::idl
