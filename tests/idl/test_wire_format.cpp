// SPDX-License-Identifier: BSD-3-Clause
// The bytes on the wire, checked against the CDR rules by hand: what any ROS 2 node must see.
#include <cstdint>
#include <cstring>
#include <vector>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

// Writes a message and reads it back undecoded, encapsulation header first.
template <class T>
std::vector<std::uint8_t> encode(const Message<T>& message) {
  const PrivateDomain domain;
  const auto participant = Participant::create(domain.settings()).value();
  const dds_entity_t topic = dds_create_topic(participant.handle(), &descriptor<T>(), "rt/wire", nullptr, nullptr);
  const UniqueQos qos = make_qos(QosProfile::kOutput);
  const dds_entity_t reader = dds_create_reader(participant.handle(), topic, qos.get(), nullptr);
  auto writer = Writer<T>::create(participant, "wire", QosProfile::kOutput).value();
  EXPECT_TRUE(writer.write(message));
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info{};
  if (dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) != 1) return {};
  const std::uint32_t size = ddsi_serdata_size(data);
  std::vector<std::uint8_t> bytes(size);
  ddsi_serdata_to_ser(data, 0, size, bytes.data());
  ddsi_serdata_unref(data);
  return bytes;
}

template <class Value>
Value value_at(const std::vector<std::uint8_t>& bytes, std::size_t offset) {
  Value value{};
  EXPECT_LE(offset + sizeof value, bytes.size());
  if (offset + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

constexpr std::size_t kEncapsulation = 4;

TEST(WireFormat, IsPlainLittleEndianCdrOfTheFirstVersion) {
  const auto bytes = encode(Message<PoseStamped>());
  ASSERT_GE(bytes.size(), kEncapsulation);
  EXPECT_EQ(bytes[0], 0x00);
  EXPECT_EQ(bytes[1], 0x01);
}

TEST(WireFormat, OfAPoseWithCovarianceIsAsRosWritesIt) {
  Message<PoseWithCovarianceStamped> message;
  message->header.stamp = {1700000000, 123456789};
  assign(message->header.frame_id, "map");
  message->pose.pose.position.x = 1.5;
  message->pose.pose.orientation.w = 0.5;
  message->pose.covariance[0] = 0.01;
  message->pose.covariance[35] = 0.02;
  const auto bytes = encode(message);
  // sec, nanosec, string length with its NUL, "map\0", then seven and thirty-six doubles
  ASSERT_EQ(bytes.size(), kEncapsulation + 4 + 4 + 4 + 4 + 7 * 8 + 36 * 8);
  EXPECT_EQ(value_at<std::int32_t>(bytes, kEncapsulation), 1700000000);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, kEncapsulation + 4), 123456789u);
  EXPECT_EQ(value_at<std::uint32_t>(bytes, kEncapsulation + 8), 4u);
  EXPECT_EQ(std::memcmp(bytes.data() + kEncapsulation + 12, "map", 4), 0);
  EXPECT_EQ(value_at<double>(bytes, kEncapsulation + 16), 1.5);
  EXPECT_EQ(value_at<double>(bytes, kEncapsulation + 16 + 6 * 8), 0.5);
  EXPECT_EQ(value_at<double>(bytes, kEncapsulation + 16 + 7 * 8), 0.01);
  EXPECT_EQ(value_at<double>(bytes, kEncapsulation + 16 + 42 * 8), 0.02);
}

TEST(WireFormat, OfAnOccupancyGridEndsWithItsSignedCells) {
  Message<OccupancyGrid> message;
  assign(message->header.frame_id, "map");
  message->info.resolution = 0.05F;
  message->info.width = 3;
  message->info.height = 1;
  allocate(message->data, 3);
  message->data._buffer[0] = -1;
  message->data._buffer[1] = 0;
  message->data._buffer[2] = 100;
  const auto bytes = encode(message);
  // header 16, load time 8, resolution, width, height 12, to the next multiple of eight 4, pose 56, length 4, cells 3
  const std::size_t length_at = kEncapsulation + 16 + 8 + 12 + 4 + 56;
  EXPECT_EQ(value_at<std::uint32_t>(bytes, length_at), 3u);
  EXPECT_EQ(value_at<std::int8_t>(bytes, length_at + 4), -1);
  EXPECT_EQ(value_at<std::int8_t>(bytes, length_at + 5), 0);
  EXPECT_EQ(value_at<std::int8_t>(bytes, length_at + 6), 100);
}

}  // namespace
}  // namespace slamfuse::idl
