// SPDX-License-Identifier: BSD-3-Clause
#include "idl/message.hpp"

#include <utility>

#include <gtest/gtest.h>

namespace slamfuse::idl {
namespace {

TEST(Message, StartsAsAllZerosWithEmptyTexts) {
  const Message<PoseWithCovarianceStamped> message;
  EXPECT_EQ(message->header.stamp.sec, 0);
  EXPECT_EQ(text_of(message->header.frame_id), "");
  for (const double value : message->pose.covariance) EXPECT_EQ(value, 0.0);
}

TEST(Message, OwnsItsTextsAndReplacesThem) {
  Message<PoseStamped> message;
  assign(message->header.frame_id, "odom");
  assign(message->header.frame_id, "map");
  EXPECT_EQ(text_of(message->header.frame_id), "map");
}

TEST(Message, MovesWithEverythingItHolds) {
  Message<TFMessage> source;
  allocate(source->transforms, 2);
  assign(source->transforms._buffer[1].child_frame_id, "base_link");
  const Message<TFMessage> target = std::move(source);
  ASSERT_EQ(target->transforms._length, 2u);
  EXPECT_EQ(text_of(target->transforms._buffer[0].child_frame_id), "");
  EXPECT_EQ(text_of(target->transforms._buffer[1].child_frame_id), "base_link");
}

TEST(Allocate, OfNothingLeavesAnEmptySequence) {
  Message<OccupancyGrid> message;
  allocate(message->data, 0);
  EXPECT_EQ(message->data._length, 0u);
}

// The names a ROS 2 node looks for; one wrong letter and nothing matches.
TEST(Descriptor, NamesTypesAsRosDoes) {
  EXPECT_STREQ(descriptor<PoseWithCovarianceStamped>().m_typename,
               "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_");
  EXPECT_STREQ(descriptor<PoseStamped>().m_typename, "geometry_msgs::msg::dds_::PoseStamped_");
  EXPECT_STREQ(descriptor<TFMessage>().m_typename, "tf2_msgs::msg::dds_::TFMessage_");
  EXPECT_STREQ(descriptor<OccupancyGrid>().m_typename, "nav_msgs::msg::dds_::OccupancyGrid_");
  EXPECT_STREQ(descriptor<Path>().m_typename, "nav_msgs::msg::dds_::Path_");
  EXPECT_STREQ(descriptor<Odometry>().m_typename, "nav_msgs::msg::dds_::Odometry_");
  EXPECT_STREQ(descriptor<LaserScan>().m_typename, "sensor_msgs::msg::dds_::LaserScan_");
  EXPECT_STREQ(descriptor<Image>().m_typename, "sensor_msgs::msg::dds_::Image_");
  EXPECT_STREQ(descriptor<CompressedImage>().m_typename, "sensor_msgs::msg::dds_::CompressedImage_");
  EXPECT_STREQ(descriptor<CameraInfo>().m_typename, "sensor_msgs::msg::dds_::CameraInfo_");
  EXPECT_STREQ(descriptor<Imu>().m_typename, "sensor_msgs::msg::dds_::Imu_");
  EXPECT_STREQ(descriptor<PointCloud2>().m_typename, "sensor_msgs::msg::dds_::PointCloud2_");
  EXPECT_STREQ(descriptor<DiagnosticArray>().m_typename, "diagnostic_msgs::msg::dds_::DiagnosticArray_");
  EXPECT_STREQ(descriptor<FusionStatus>().m_typename, "slamfuse_msgs::msg::dds_::FusionStatus_");
}

}  // namespace
}  // namespace slamfuse::idl
