// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <builtin_interfaces.h>
#include <diagnostic_msgs.h>
#include <geometry_msgs.h>
#include <nav_msgs.h>
#include <sensor_msgs.h>
#include <slamfuse_msgs.h>
#include <std_msgs.h>
#include <tf2_msgs.h>

/// The C structs idlc generates, under the names ROS 2 users know.
namespace slamfuse::idl {

using Time = builtin_interfaces_msg_dds__Time_;
using Header = std_msgs_msg_dds__Header_;
using Point = geometry_msgs_msg_dds__Point_;
using Quaternion = geometry_msgs_msg_dds__Quaternion_;
using Pose = geometry_msgs_msg_dds__Pose_;
using PoseStamped = geometry_msgs_msg_dds__PoseStamped_;
using PoseWithCovarianceStamped = geometry_msgs_msg_dds__PoseWithCovarianceStamped_;
using TransformStamped = geometry_msgs_msg_dds__TransformStamped_;
using LaserScan = sensor_msgs_msg_dds__LaserScan_;
using Image = sensor_msgs_msg_dds__Image_;
using CompressedImage = sensor_msgs_msg_dds__CompressedImage_;
using CameraInfo = sensor_msgs_msg_dds__CameraInfo_;
using Imu = sensor_msgs_msg_dds__Imu_;
using PointField = sensor_msgs_msg_dds__PointField_;
using PointCloud2 = sensor_msgs_msg_dds__PointCloud2_;
using Odometry = nav_msgs_msg_dds__Odometry_;
using Path = nav_msgs_msg_dds__Path_;
using OccupancyGrid = nav_msgs_msg_dds__OccupancyGrid_;
using TFMessage = tf2_msgs_msg_dds__TFMessage_;
using KeyValue = diagnostic_msgs_msg_dds__KeyValue_;
using DiagnosticStatus = diagnostic_msgs_msg_dds__DiagnosticStatus_;
using DiagnosticArray = diagnostic_msgs_msg_dds__DiagnosticArray_;
using SourceStatus = slamfuse_msgs_msg_dds__SourceStatus_;
using FusionStatus = slamfuse_msgs_msg_dds__FusionStatus_;

/// How Cyclone writes and reads a message type. Specialised for every type that may be a topic.
template <class T>
const dds_topic_descriptor_t& descriptor();

template <>
inline const dds_topic_descriptor_t& descriptor<PoseStamped>() {
  return geometry_msgs_msg_dds__PoseStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<PoseWithCovarianceStamped>() {
  return geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<LaserScan>() {
  return sensor_msgs_msg_dds__LaserScan__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Image>() {
  return sensor_msgs_msg_dds__Image__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<CompressedImage>() {
  return sensor_msgs_msg_dds__CompressedImage__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<CameraInfo>() {
  return sensor_msgs_msg_dds__CameraInfo__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Imu>() {
  return sensor_msgs_msg_dds__Imu__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<PointCloud2>() {
  return sensor_msgs_msg_dds__PointCloud2__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Odometry>() {
  return nav_msgs_msg_dds__Odometry__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<Path>() {
  return nav_msgs_msg_dds__Path__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<OccupancyGrid>() {
  return nav_msgs_msg_dds__OccupancyGrid__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<TFMessage>() {
  return tf2_msgs_msg_dds__TFMessage__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<DiagnosticArray>() {
  return diagnostic_msgs_msg_dds__DiagnosticArray__desc;
}
template <>
inline const dds_topic_descriptor_t& descriptor<FusionStatus>() {
  return slamfuse_msgs_msg_dds__FusionStatus__desc;
}

}  // namespace slamfuse::idl
