// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros_bag_samples.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include <bzlib.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include "common/recording_samples.hpp"

namespace slamfuse::common::samples {
namespace {

std::string little_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xFFU);
  return text;
}

std::string counted(const std::string& bytes) { return little_endian(bytes.size(), 4) + bytes; }

std::string field(const std::string& name, const std::string& value) { return counted(name + "=" + value); }

std::string record(const std::string& header, const std::string& data) { return counted(header) + counted(data); }

std::string compressed(const std::string& content, const std::string& compression) {
  if (compression == "bz2") {
    std::string packed(content.size() + content.size() / 100 + 600, '\0');
    auto size = static_cast<unsigned>(packed.size());
    std::string copy = content;
    EXPECT_EQ(BZ2_bzBuffToBuffCompress(packed.data(), &size, copy.data(), static_cast<unsigned>(copy.size()), 9, 0, 0),
              BZ_OK);
    packed.resize(size);
    return packed;
  }
  if (compression == "lz4") {
    std::string packed(LZ4F_compressFrameBound(content.size(), nullptr), '\0');
    packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), content.data(), content.size(), nullptr));
    return packed;
  }
  if (compression == "zstd") {
    std::string packed(ZSTD_compressBound(content.size()), '\0');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), content.data(), content.size(), 3));
    return packed;
  }
  return content;
}

std::string type_of_ros2(std::string type) { return type.insert(type.find('/'), "/msg"); }

/// Runs SQL that must succeed.
void run(sqlite3* database, const char* sql) {
  ASSERT_EQ(sqlite3_exec(database, sql, nullptr, nullptr, nullptr), SQLITE_OK);
}

}  // namespace

WireWriter& WireWriter::text(const std::string& text) {
  const bool cdr = wire_ != Wire::kRos1;
  number(static_cast<std::uint32_t>(text.size() + (cdr ? 1 : 0)));
  bytes_ += text;
  if (cdr) bytes_ += '\0';
  return *this;
}

WireWriter& WireWriter::header(Nanoseconds stamp, const std::string& frame) {
  if (wire_ == Wire::kRos1) number(std::uint32_t{7});
  number(static_cast<std::uint32_t>(stamp / kNanosecondsPerSecond));
  number(static_cast<std::uint32_t>(stamp % kNanosecondsPerSecond));
  return text(frame);
}

WireWriter& WireWriter::pose(const Pose3& pose) {
  for (int i = 0; i < 3; ++i) number(pose.translation[i]);
  for (int i = 0; i < 4; ++i) number(pose.rotation.coeffs()[i]);
  return *this;
}

std::string scan_message(Wire wire, const SampleScan& scan) {
  WireWriter writer(wire);
  writer.header(scan.stamp, scan.frame);
  const float angle_max = scan.angle_min + static_cast<float>(scan.ranges.size() - 1) * scan.angle_increment;
  writer.number(scan.angle_min).number(angle_max).number(scan.angle_increment).number(scan.time_increment);
  writer.number(0.2F).number(scan.range_min).number(scan.range_max);
  return writer.list(scan.ranges).list(std::vector<float>{}).bytes();
}

std::string odometry_message(Wire wire, Nanoseconds stamp, const std::string& child, const Pose3& pose,
                             double forward_speed, double turn_rate) {
  WireWriter writer(wire);
  writer.header(stamp, "odom").text(child).pose(pose);
  for (int i = 0; i < 36; ++i) writer.number(0.0);
  for (const double speed : {forward_speed, 0.0, 0.0, 0.0, 0.0, turn_rate}) writer.number(speed);
  for (int i = 0; i < 36; ++i) writer.number(0.0);
  return writer.bytes();
}

std::string pose_message(Wire wire, Nanoseconds stamp, const Pose3& pose) {
  return WireWriter(wire).header(stamp, "world").pose(pose).bytes();
}

std::string transforms_message(Wire wire, Nanoseconds stamp, const std::vector<SampleTransform>& transforms) {
  WireWriter writer(wire);
  writer.number(static_cast<std::uint32_t>(transforms.size()));
  for (const SampleTransform& transform : transforms) {
    writer.header(stamp, transform.parent).text(transform.child).pose(transform.pose);
  }
  return writer.bytes();
}

std::string image_message(Wire wire, Nanoseconds stamp, const std::string& encoding, std::uint32_t width,
                          std::uint32_t height, const std::string& data) {
  WireWriter writer(wire);
  writer.header(stamp, "camera_optical").number(height).number(width).text(encoding).number(std::uint8_t{0});
  writer.number(static_cast<std::uint32_t>(data.size() / height));
  return writer.list(std::vector<std::uint8_t>(data.begin(), data.end())).bytes();
}

std::string compressed_image_message(Wire wire, Nanoseconds stamp, const std::string& data) {
  WireWriter writer(wire);
  writer.header(stamp, "camera_optical").text("jpeg");
  return writer.list(std::vector<std::uint8_t>(data.begin(), data.end())).bytes();
}

std::string camera_info_message(Wire wire, std::uint32_t width, std::uint32_t height, double focal_length) {
  WireWriter writer(wire);
  writer.header(kSampleStart, "camera_optical").number(height).number(width).text("plumb_bob");
  writer.list(std::vector<double>{-0.1, 0.02, 0.001, -0.002, 0.0});
  for (const double k : {focal_length, 0.0, width / 2.0, 0.0, focal_length, height / 2.0, 0.0, 0.0, 1.0}) {
    writer.number(k);
  }
  return writer.bytes();
}

Pose3 planar(double x, double y, double yaw) { return to_pose3({x, y, yaw}); }

std::string ros1_bag(const std::vector<BagSample>& samples, const std::string& compression, std::size_t in_chunk) {
  std::map<std::string, std::uint32_t> connections;
  for (const BagSample& sample : samples) {
    connections.try_emplace(sample.topic, static_cast<std::uint32_t>(connections.size()));
  }
  const std::string zeros(8, '\0');
  std::string bag = "#ROSBAG V2.0\n";
  bag += record(field("op", "\x03") + field("index_pos", zeros) + field("conn_count", little_endian(0, 4)) +
                    field("chunk_count", little_endian(0, 4)),
                std::string(100, ' '));
  for (std::size_t begin = 0; begin < samples.size(); begin += in_chunk) {
    std::string content;
    for (std::size_t i = begin; i < std::min(samples.size(), begin + in_chunk); ++i) {
      const BagSample& sample = samples[i];
      const std::string connection = field("conn", little_endian(connections.at(sample.topic), 4));
      content += record(field("op", "\x07") + connection + field("topic", sample.topic),
                        field("topic", sample.topic) + field("type", sample.type) + field("md5sum", "*"));
      const auto seconds = static_cast<std::uint64_t>(sample.stored / kNanosecondsPerSecond);
      const auto rest = static_cast<std::uint64_t>(sample.stored % kNanosecondsPerSecond);
      content +=
          record(field("op", "\x02") + connection + field("time", little_endian(seconds, 4) + little_endian(rest, 4)),
                 sample.data);
    }
    bag += record(
        field("op", "\x05") + field("compression", compression) + field("size", little_endian(content.size(), 4)),
        compressed(content, compression));
  }
  return bag;
}

std::string mcap_file(const std::vector<BagSample>& samples, const std::string& compression, std::size_t in_chunk) {
  const auto record = [](char operation, const std::string& content) {
    return operation + little_endian(content.size(), 8) + content;
  };
  const std::string none = little_endian(0, 4);  // an empty text, list or map
  std::string file = "\x89MCAP0\r\n" + record('\x01', counted("ros2") + none);
  std::map<std::string, std::uint16_t> channels;
  for (std::size_t begin = 0; begin < samples.size(); begin += in_chunk) {
    std::string content;
    for (std::size_t i = begin; i < std::min(samples.size(), begin + in_chunk); ++i) {
      const BagSample& sample = samples[i];
      const auto [channel, is_new] =
          channels.try_emplace(sample.topic, static_cast<std::uint16_t>(channels.size() + 1));
      const std::string id = little_endian(channel->second, 2);
      if (is_new) {
        content += record('\x03', id + counted(type_of_ros2(sample.type)) + counted("ros2msg") + none);
        content += record('\x04', id + id + counted(sample.topic) + counted("cdr") + none);
      }
      const std::string time = little_endian(static_cast<std::uint64_t>(sample.stored), 8);
      content += record('\x05', id + little_endian(i, 4) + time + time + sample.data);
    }
    const std::string stored = compressed(content, compression.empty() ? "none" : compression);
    const std::string times(16, '\0');
    const auto checksum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    file += record('\x06', times + little_endian(content.size(), 8) + little_endian(checksum, 4) +
                               counted(compression) + little_endian(stored.size(), 8) + stored);
  }
  file += record('\x0F', none);
  return file + record('\x02', std::string(20, '\0')) + "\x89MCAP0\r\n";
}

std::filesystem::path write_mcap_bag(const std::filesystem::path& folder, const std::vector<BagSample>& samples,
                                     const std::string& compression) {
  std::filesystem::create_directories(folder);
  write_file(folder / "metadata.yaml",
             "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  compression_format: \"\"\n"
             "  compression_mode: \"\"\n  relative_file_paths:\n    - bag_0.mcap\n");
  write_file(folder / "bag_0.mcap", mcap_file(samples, compression));
  return folder / "bag_0.mcap";
}

std::filesystem::path write_ros2_bag(const std::filesystem::path& folder, const std::vector<BagSample>& samples) {
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / "bag_0.db3";
  std::filesystem::remove(file);
  write_file(folder / "metadata.yaml",
             "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  compression_format: \"\"\n"
             "  compression_mode: \"\"\n  relative_file_paths:\n    - bag_0.db3\n");
  sqlite3* database = nullptr;
  if (sqlite3_open(file.c_str(), &database) != SQLITE_OK) throw std::runtime_error("no database");
  run(database,
      "BEGIN; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
      "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);");
  std::map<std::string, int> topics;
  sqlite3_stmt* topic_row = nullptr;
  sqlite3_stmt* message_row = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", -1, &topic_row, nullptr);
  sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", -1, &message_row,
                     nullptr);
  for (const BagSample& sample : samples) {
    const auto [topic, is_new] = topics.try_emplace(sample.topic, static_cast<int>(topics.size()) + 1);
    if (is_new) {
      const std::string type = type_of_ros2(sample.type);
      sqlite3_bind_int(topic_row, 1, topic->second);
      sqlite3_bind_text(topic_row, 2, sample.topic.c_str(), -1, SQLITE_TRANSIENT);
      sqlite3_bind_text(topic_row, 3, type.c_str(), -1, SQLITE_TRANSIENT);
      EXPECT_EQ(sqlite3_step(topic_row), SQLITE_DONE);
      sqlite3_reset(topic_row);
    }
    sqlite3_bind_int(message_row, 1, topic->second);
    sqlite3_bind_int64(message_row, 2, sample.stored);
    sqlite3_bind_blob(message_row, 3, sample.data.data(), static_cast<int>(sample.data.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(message_row), SQLITE_DONE);
    sqlite3_reset(message_row);
  }
  sqlite3_finalize(topic_row);
  sqlite3_finalize(message_row);
  run(database, "COMMIT;");
  sqlite3_close(database);
  return file;
}

}  // namespace slamfuse::common::samples
