// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

#include "common/pose3.hpp"
#include "common/time.hpp"

namespace slamfuse::common::samples {

enum class Wire { kRos1, kCdr, kBigEndianCdr };

/// Serialises a message: the counterpart of the readers in common/wire_reader.hpp.
class WireWriter {
 public:
  explicit WireWriter(Wire wire) : wire_(wire) {
    if (wire_ == Wire::kCdr) bytes_ = std::string("\0\1\0\0", 4);
    if (wire_ == Wire::kBigEndianCdr) bytes_ = std::string(4, '\0');
  }
  template <class Number>
  WireWriter& number(Number value) {
    while (wire_ != Wire::kRos1 && (bytes_.size() - 4) % sizeof(Number) != 0) bytes_ += '\0';
    std::string raw(reinterpret_cast<const char*>(&value), sizeof(Number));
    if ((wire_ == Wire::kBigEndianCdr) != (std::endian::native == std::endian::big)) {
      raw = std::string(raw.rbegin(), raw.rend());
    }
    bytes_ += raw;
    return *this;
  }
  template <class Number>
  WireWriter& list(const std::vector<Number>& items) {
    number(static_cast<std::uint32_t>(items.size()));
    for (const Number item : items) number(item);
    return *this;
  }
  WireWriter& text(const std::string& text);
  WireWriter& header(Nanoseconds stamp, const std::string& frame);
  WireWriter& pose(const Pose3& pose);
  const std::string& bytes() const { return bytes_; }

 private:
  Wire wire_;
  std::string bytes_;
};

/// A scan with settings a test may change.
struct SampleScan {
  Nanoseconds stamp = 0;
  std::string frame = "laser";
  float angle_min = -1.5F;
  float angle_increment = 1.0F;
  float time_increment = 0.0F;
  float range_min = 0.1F;
  float range_max = 10.0F;
  std::vector<float> ranges{1.0F, 2.0F, 3.0F, 4.0F};
};

struct SampleTransform {
  std::string parent;
  std::string child;
  Pose3 pose;
};

std::string scan_message(Wire wire, const SampleScan& scan);
std::string odometry_message(Wire wire, Nanoseconds stamp, const std::string& child, const Pose3& pose,
                             double forward_speed = 0.0, double turn_rate = 0.0);
std::string pose_message(Wire wire, Nanoseconds stamp, const Pose3& pose);
std::string transforms_message(Wire wire, Nanoseconds stamp, const std::vector<SampleTransform>& transforms);
std::string image_message(Wire wire, Nanoseconds stamp, const std::string& encoding, std::uint32_t width,
                          std::uint32_t height, const std::string& data);
std::string compressed_image_message(Wire wire, Nanoseconds stamp, const std::string& data);
std::string camera_info_message(Wire wire, std::uint32_t width, std::uint32_t height, double focal_length);

/// The pose (x, y, yaw) in space.
Pose3 planar(double x, double y, double yaw);

/// A message of a bag to be written.
struct BagSample {
  std::string topic;
  std::string type;  ///< as in ROS 1
  Nanoseconds stored = 0;
  std::string data;
};

/// A ROS 1 bag: magic, bag header, chunks of `in_chunk` messages each with the connections it needs; no index, as in a
/// bag whose recorder was killed. `compression`: none, bz2, lz4.
std::string ros1_bag(const std::vector<BagSample>& samples, const std::string& compression = "none",
                     std::size_t in_chunk = 3);

/// An MCAP file of ROS 2 without its optional summary, in chunks of `in_chunk` messages. `compression`: empty, lz4,
/// zstd.
std::string mcap_file(const std::vector<BagSample>& samples, const std::string& compression = "",
                      std::size_t in_chunk = 3);

/// Writes a ROS 2 bag of MCAP: the folder with metadata.yaml and one .mcap file, whose path is returned.
std::filesystem::path write_mcap_bag(const std::filesystem::path& folder, const std::vector<BagSample>& samples,
                                     const std::string& compression = "");

/// Writes a ROS 2 bag of SQLite: the folder with metadata.yaml and one .db3 file, whose path is returned.
std::filesystem::path write_ros2_bag(const std::filesystem::path& folder, const std::vector<BagSample>& samples);

}  // namespace slamfuse::common::samples
