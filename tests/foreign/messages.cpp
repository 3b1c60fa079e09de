// SPDX-License-Identifier: BSD-3-Clause
#include "foreign/messages.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <sstream>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include "common/pose3.hpp"

namespace foreign {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using namespace slamfuse::common;

constexpr Nanoseconds kSecond = 1'000'000'000;

template <class Fill>
std::vector<char> write(const Fill& fill) {
  FastBuffer buffer;
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  fill(cdr);
  return {cdr.getBufferPointer(), cdr.getBufferPointer() + cdr.getSerializedDataLength()};
}

template <class Use>
std::string read(std::vector<char>& message, const Use& use) {
  FastBuffer buffer(message.data(), message.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
  cdr.read_encapsulation();
  std::ostringstream text;
  text.precision(12);
  use(cdr, text);
  return text.str();
}

void write_header(Cdr& cdr, Nanoseconds stamp, const std::string& frame) {
  cdr << static_cast<std::int32_t>(stamp / kSecond) << static_cast<std::uint32_t>(stamp % kSecond) << frame;
}

struct Header {
  Nanoseconds stamp = 0;
  std::string frame;
};
Header read_header(Cdr& cdr) {
  std::int32_t seconds = 0;
  std::uint32_t nanoseconds = 0;
  Header header;
  cdr >> seconds >> nanoseconds >> header.frame;
  header.stamp = seconds * kSecond + nanoseconds;
  return header;
}

template <std::size_t Count>
std::array<double, Count> read_numbers(Cdr& cdr) {
  std::array<double, Count> numbers{};
  for (double& number : numbers) cdr >> number;
  return numbers;
}

}  // namespace

std::vector<char> scan_message(const LaserScan& scan, const LaserCalibration& laser) {
  return write([&](Cdr& cdr) {
    write_header(cdr, scan.stamp, scan.sensor);
    const auto steps = static_cast<double>(scan.ranges.size() - 1);
    cdr << static_cast<float>(laser.angle_min) << static_cast<float>(laser.angle_min + steps * laser.angle_increment)
        << static_cast<float>(laser.angle_increment) << static_cast<float>(laser.sweep_duration / steps)
        << static_cast<float>(laser.sweep_duration) << static_cast<float>(laser.range_min)
        << static_cast<float>(laser.range_max);
    cdr << scan.ranges << std::vector<float>();
  });
}

std::vector<char> image_message(const Image& image) {
  return write([&](Cdr& cdr) {
    write_header(cdr, image.stamp, image.sensor);
    cdr << static_cast<std::uint32_t>(image.height) << static_cast<std::uint32_t>(image.width) << std::string("mono8")
        << std::uint8_t{0} << static_cast<std::uint32_t>(image.width) << *image.pixels;
  });
}

std::vector<char> camera_info_message(const std::string& camera, Nanoseconds stamp,
                                      const CameraCalibration& calibration) {
  return write([&](Cdr& cdr) {
    write_header(cdr, stamp, camera);
    cdr << static_cast<std::uint32_t>(calibration.height) << static_cast<std::uint32_t>(calibration.width)
        << std::string("plumb_bob");
    cdr << std::vector<double>{calibration.k1, calibration.k2, calibration.p1, calibration.p2, calibration.k3};
    for (const double k : {calibration.fx, 0.0, calibration.cx, 0.0, calibration.fy, calibration.cy, 0.0, 0.0, 1.0})
      cdr << k;
    for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) cdr << r;
    for (const double p :
         {calibration.fx, 0.0, calibration.cx, 0.0, 0.0, calibration.fy, calibration.cy, 0.0, 0.0, 0.0, 1.0, 0.0}) {
      cdr << p;
    }
    for (int i = 0; i < 6; ++i) cdr << std::uint32_t{0};  // binning and region
    cdr << false;
  });
}

std::vector<char> odometry_message(const WheelOdometry& odometry) {
  return write([&](Cdr& cdr) {
    write_header(cdr, odometry.stamp, "odom");
    const double half = odometry.pose.theta / 2.0;
    cdr << std::string("base_link") << odometry.pose.x << odometry.pose.y << 0.0 << 0.0 << 0.0 << std::sin(half)
        << std::cos(half);
    for (int i = 0; i < 36; ++i) cdr << 0.0;
    cdr << odometry.forward_speed << 0.0 << 0.0 << 0.0 << 0.0 << odometry.turn_rate;
    for (int i = 0; i < 36; ++i) cdr << 0.0;
  });
}

std::vector<char> mountings_message(const Calibration& calibration) {
  return write([&](Cdr& cdr) {
    cdr << static_cast<std::uint32_t>(calibration.lasers.size() + calibration.cameras.size());
    const auto add = [&](const std::string& child, const Pose3& pose) {
      write_header(cdr, kSecond, "base_link");
      cdr << child << pose.translation.x() << pose.translation.y() << pose.translation.z() << pose.rotation.x()
          << pose.rotation.y() << pose.rotation.z() << pose.rotation.w();
    };
    for (const auto& [name, laser] : calibration.lasers) add(name, laser.T_base_laser);
    for (const auto& [name, camera] : calibration.cameras) add(name, camera.T_base_camera);
  });
}

std::string read_pose(std::vector<char>& message) {
  return read(message, [](Cdr& cdr, std::ostream& text) {
    const Header header = read_header(cdr);
    const auto pose = read_numbers<7>(cdr);
    const auto covariance = read_numbers<36>(cdr);
    text << "pose " << header.stamp << ' ' << header.frame << ' ' << pose[0] << ' ' << pose[1] << ' ' << pose[5] << ' '
         << pose[6] << ' ' << covariance[0];
  });
}

std::string read_transform(std::vector<char>& message) {
  return read(message, [](Cdr& cdr, std::ostream& text) {
    std::uint32_t count = 0;
    cdr >> count;
    const Header header = read_header(cdr);
    std::string child;
    cdr >> child;
    const auto pose = read_numbers<7>(cdr);
    text << "tf " << header.stamp << ' ' << header.frame << ' ' << child << ' ' << pose[0] << ' ' << pose[1];
  });
}

std::string read_map(std::vector<char>& message) {
  return read(message, [](Cdr& cdr, std::ostream& text) {
    const Header header = read_header(cdr);
    std::int32_t load_seconds = 0;
    std::uint32_t load_nanoseconds = 0;
    float resolution = 0.0F;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    cdr >> load_seconds >> load_nanoseconds >> resolution >> width >> height;
    const auto origin = read_numbers<7>(cdr);
    std::vector<std::int8_t> cells;
    cdr >> cells;
    std::size_t occupied = 0;
    std::size_t free = 0;
    for (const std::int8_t cell : cells) {
      occupied += cell > 65 ? 1 : 0;
      free += cell >= 0 && cell < 20 ? 1 : 0;
    }
    text << "map " << header.frame << ' ' << width << ' ' << height << ' ' << resolution << ' ' << origin[0] << ' '
         << origin[1] << ' ' << occupied << ' ' << free;
  });
}

std::string read_status(std::vector<char>& message) {
  return read(message, [](Cdr& cdr, std::ostream& text) {
    const Header header = read_header(cdr);
    std::uint8_t state = 0;
    double score = 0.0;
    std::vector<std::string> reasons;
    std::uint32_t sources = 0;
    cdr >> state >> score >> reasons >> sources;
    text << "status " << header.stamp << ' ' << static_cast<int>(state) << ' ' << score << ' ' << sources;
  });
}

std::string read_landmarks(std::vector<char>& message) {
  return read(message, [](Cdr& cdr, std::ostream& text) {
    const Header header = read_header(cdr);
    std::uint32_t height = 0;
    std::uint32_t width = 0;
    std::uint32_t fields = 0;
    cdr >> height >> width >> fields;
    for (std::uint32_t i = 0; i < fields; ++i) {
      std::string name;
      std::uint32_t offset = 0;
      std::uint8_t type = 0;
      std::uint32_t count = 0;
      cdr >> name >> offset >> type >> count;
    }
    bool big_endian = false;
    std::uint32_t point_step = 0;
    std::uint32_t row_step = 0;
    std::vector<std::uint8_t> data;
    cdr >> big_endian >> point_step >> row_step >> data;
    std::array<float, 3> first{};
    if (data.size() >= sizeof(first)) std::memcpy(first.data(), data.data(), sizeof(first));
    text << "landmarks " << header.frame << ' ' << static_cast<std::size_t>(width) * height << ' ' << first[0] << ' '
         << first[1] << ' ' << first[2];
  });
}

}  // namespace foreign
