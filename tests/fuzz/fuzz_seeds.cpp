// SPDX-License-Identifier: BSD-3-Clause
// Writes small good samples of every format, from which the fuzzers start:
//
//     fuzz_seeds FOLDER
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <bzlib.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include "common/recording_samples.hpp"
#include "common/ros_bag_samples.hpp"
#include "laser_slam/laser_slam.hpp"
#include "service/grid_file.hpp"
#include "service/map_bundle.hpp"

namespace {

namespace fs = std::filesystem;
using namespace slamfuse;
using namespace slamfuse::common::samples;

constexpr char kSeparator = '\xff';
constexpr common::Nanoseconds kSecond = 1'000'000'000;

std::vector<BagSample> bag_samples(Wire wire) {
  std::vector<BagSample> samples;
  const std::vector<SampleTransform> mounts{{"base_link", "laser", planar(0.1, 0.0, 0.0)},
                                            {"base_link", "camera", planar(0.2, 0.0, 0.0)}};
  samples.push_back({"/tf_static", "tf2_msgs/TFMessage", kSecond, transforms_message(wire, kSecond, mounts)});
  samples.push_back(
      {"/camera/camera_info", "sensor_msgs/CameraInfo", kSecond, camera_info_message(wire, 16, 12, 20.0)});
  for (int i = 1; i <= 4; ++i) {
    const common::Nanoseconds stamp = i * kSecond;
    samples.push_back({"/odom", "nav_msgs/Odometry", stamp,
                       odometry_message(wire, stamp, "base_link", planar(0.1 * i, 0.0, 0.0), 0.1, 0.0)});
    SampleScan scan;
    scan.stamp = stamp;
    samples.push_back({"/scan", "sensor_msgs/LaserScan", stamp, scan_message(wire, scan)});
    samples.push_back({"/camera/image_raw", "sensor_msgs/Image", stamp,
                       image_message(wire, stamp, "mono8", 16, 12, std::string(16 * 12, 'x'))});
  }
  return samples;
}

std::string rawlog() {
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  for (int i = 0; i < 3; ++i) {
    mrpt::obs::CActionRobotMovement2D movement;
    movement.computeFromOdometry(mrpt::poses::CPose2D(0.1, 0, 0.1), {});
    mrpt::obs::CActionCollection actions;
    actions.insert(movement);
    auto scan = std::make_shared<mrpt::obs::CObservation2DRangeScan>();
    scan->timestamp = mrpt::Clock::fromDouble(1e9 + i);
    scan->aperture = static_cast<float>(std::numbers::pi);
    scan->maxRange = 10.0F;
    scan->resizeScan(5);
    for (std::size_t k = 0; k < 5; ++k) {
      scan->setScanRange(k, 1.0F + static_cast<float>(k));
      scan->setScanRangeValidity(k, true);
    }
    mrpt::obs::CSensoryFrame frame;
    frame.insert(scan);
    archive << actions << frame;
  }
  return {static_cast<const char*>(stream.getRawBufferData()), static_cast<std::size_t>(stream.getTotalBytesCount())};
}

std::string carmen() {
  std::string log = "# CARMEN Logfile\nPARAM robot_frontlaser_offset 0.3 1.0 host 0\n";
  for (int i = 0; i < 4; ++i) {
    const std::string pose = std::to_string(0.1 * i) + " 0 0 ";
    log += "ODOM " + pose + "0.1 0 0 " + std::to_string(i) + ".0 host " + std::to_string(i) + ".0\n";
    log += "FLASER 4 1.0 2.0 3.0 4.0 " + pose + pose + std::to_string(i) + ".5 host " + std::to_string(i) + ".5\n";
  }
  return log;
}

std::string bzip2(std::string text) {
  std::string packed(text.size() + 1000, '\0');
  auto size = static_cast<unsigned>(packed.size());
  BZ2_bzBuffToBuffCompress(packed.data(), &size, text.data(), static_cast<unsigned>(text.size()), 1, 0, 0);
  packed.resize(size);
  return packed;
}

std::string euroc(const fs::path& scratch) {
  write_euroc_sample(scratch / "euroc");
  std::string joined;
  for (const char* file : {"laser0/sensor.yaml", "laser0/data.csv", "odom0/data.csv", "cam0/sensor.yaml"}) {
    joined += read_file(scratch / "euroc" / file) + kSeparator;
  }
  joined += "#timestamp [ns],filename\n1700000000000000000,1.png\n";
  joined += kSeparator + encoded_image(".png", 1) + kSeparator;
  return joined + "#timestamp,x,y,z,qw,qx,qy,qz\n1700000000000000000,0,0,0,1,0,0,0\n";
}

void write_messages(const fs::path& folder) {
  const auto write = [&](int type, const std::string& name, const auto& message_of) {
    write_file(folder / "ros_message" / (name + "_cdr"),
               std::string(1, static_cast<char>(type)) + message_of(Wire::kCdr));
    write_file(folder / "ros_message" / (name + "_be"),
               std::string(1, static_cast<char>(type)) + message_of(Wire::kBigEndianCdr));
    write_file(folder / "ros_message" / (name + "_ros1"),
               std::string(1, static_cast<char>(0x80 | type)) + message_of(Wire::kRos1));
  };
  // Cyclone hands the message over without its encapsulation header.
  const auto write_live = [&](int type, const std::string& name, const std::string& cdr) {
    write_file(folder / "live_message" / name, std::string(1, static_cast<char>(type)) + cdr.substr(4));
  };
  const auto scan = [](Wire wire) { return scan_message(wire, {}); };
  const auto odometry = [](Wire wire) { return odometry_message(wire, 1, "base_link", planar(1, 2, 0.3)); };
  const auto transforms = [](Wire wire) {
    return transforms_message(wire, 1, {{"base_link", "laser", planar(1, 2, 0.3)}});
  };
  const auto image = [](Wire wire) { return image_message(wire, 1, "mono8", 64, 48, std::string(64 * 48, 'x')); };
  const auto compressed = [](Wire wire) { return compressed_image_message(wire, 1, encoded_image(".png", 1, 64, 48)); };
  const auto camera = [](Wire wire) { return camera_info_message(wire, 64, 48, 50.0); };
  const auto pose = [](Wire wire) { return pose_message(wire, 1, planar(1, 2, 0.3)); };
  write(0, "scan", scan);
  write(1, "odometry", odometry);
  write(2, "transforms", transforms);
  write(3, "image", image);
  write(4, "compressed", compressed);
  write(5, "camera", camera);
  write(6, "pose", pose);
  write_live(0, "scan", scan(Wire::kCdr));
  write_live(1, "odometry", odometry(Wire::kCdr));
  write_live(2, "image", image(Wire::kCdr));
  write_live(3, "compressed", compressed(Wire::kCdr));
  write_live(4, "camera", camera(Wire::kCdr));
  write_live(5, "transforms", transforms(Wire::kCdr));
  write_live(7, "pose", pose(Wire::kCdr));
}

std::string laser_state() {
  laser_slam::LaserSlamOptions options;
  options.particles = 2;
  common::LaserCalibration laser;
  laser.beams = 8;
  laser.angle_min = -1.0;
  laser.angle_increment = 0.25;
  laser.range_min = 0.1;
  laser.range_max = 10.0;
  const auto slam = laser_slam::LaserSlam::create(options, "laser0", laser, 1, 1);
  (*slam)->process(common::LaserScan{kSecond, "laser0", std::vector<float>(8, 2.0F)});
  return (*slam)->serialize().value();
}

void write_maps(const fs::path& folder) {
  common::OccupancyGrid grid;
  grid.width = grid.height = 8;
  grid.resolution = 0.05;
  grid.cells.assign(64, 0);
  service::MapBundle bundle;
  bundle.grid = &grid;
  const std::string state = laser_state();
  bundle.laser_state = state;
  bundle.landmarks.resize(2);
  const fs::path map = folder / "map";
  if (!service::write_map_bundle(bundle, map)) throw std::runtime_error("no map");
  std::string yaml = read_file(map / "map.yaml");
  write_file(folder / "map_files/yaml", '\0' + yaml);
  yaml.resize(yaml.rfind("crc32"));
  write_file(folder / "map_files/yaml_unsealed", '\0' + yaml);
  write_file(folder / "map_files/landmarks", '\1' + read_file(map / "landmarks.bin"));
  const std::string pair = read_file(map / "grid.yaml") + kSeparator + read_file(map / "grid.pgm");
  write_file(folder / "map_files/grid", '\2' + pair);
  write_file(folder / "map_files/nav2",
             "\3image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
             "free_thresh: 0.196\n" +
                 (kSeparator + read_file(map / "grid.pgm")));
  write_file(folder / "laser_state/state", state);
  fs::remove_all(map);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const fs::path folder = argv[1];
  for (const char* name :
       {"recording_file", "recording_folder", "ros_message", "live_message", "map_files", "laser_state", "options"}) {
    fs::create_directories(folder / name);
  }
  const fs::path recordings = folder / "recording_file";
  write_file(recordings / "carmen", carmen());
  write_file(recordings / "carmen_bz2", bzip2(carmen()));
  write_file(recordings / "rawlog", rawlog());
  for (const char* compression : {"none", "bz2", "lz4"}) {
    write_file(recordings / (std::string("ros1_") + compression), ros1_bag(bag_samples(Wire::kRos1), compression));
  }
  for (const char* compression : {"", "lz4", "zstd"}) {
    write_file(recordings / (std::string("mcap_") + compression), mcap_file(bag_samples(Wire::kCdr), compression));
  }
  const TemporaryFolder scratch;
  write_file(recordings / "ros2", read_file(write_ros2_bag(scratch.path() / "bag", bag_samples(Wire::kCdr))));
  write_file(folder / "recording_folder/euroc", euroc(scratch.path()));
  write_messages(folder);
  write_maps(folder);
  write_file(folder / "options/laser", "laser:\n  particles: 30\n");
  return 0;
}
