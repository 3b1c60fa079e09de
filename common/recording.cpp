// SPDX-License-Identifier: BSD-3-Clause
#include "common/recording.hpp"

#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "common/byte_source.hpp"
#include "common/carmen_recording.hpp"
#include "common/euroc_recording.hpp"
#include "common/image_folder_recording.hpp"
#include "common/rawlog_recording.hpp"
#include "common/ros_bag.hpp"
#include "common/ros_recording.hpp"

namespace slamfuse::common {
namespace {

constexpr const char* kKnownFormats =
    "an EuRoC/ASL folder, a folder of images with sensor.yaml, a CARMEN log, an MRPT rawlog, a ROS 2 bag (sqlite3, "
    "MCAP), a "
    "ROS 1 bag";

/// The first bytes of a file, decompressed: enough to get past the comments and parameters at the head of a log.
Result<std::string> beginning_of(const std::filesystem::path& path) {
  Result<std::unique_ptr<ByteSource>> source = open_byte_source(path);
  if (!source) return tl::unexpected(source.error());
  constexpr std::size_t kEnough = 1U << 18;
  std::string beginning(kEnough, '\0');
  std::size_t size = 0;
  while (size < kEnough) {
    const Result<std::size_t> count = (*source)->read(std::span(beginning).subspan(size));
    if (!count && size == 0) return tl::unexpected(count.error());
    if (!count || *count == 0) break;
    size += *count;
  }
  beginning.resize(size);
  return beginning;
}

/// The bag of a path that is one.
Result<std::unique_ptr<RosBag>> open_bag(const std::filesystem::path& path) {
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) return open_ros2_bag(path);
  const Result<std::string> beginning = beginning_of(path);
  if (beginning && is_ros1_bag(*beginning)) return open_ros1_bag(path);
  if (beginning && is_mcap_file(*beginning)) return open_mcap_bag({path});
  return open_ros2_bag(path);
}

/// Opens what is not a bag.
Result<std::unique_ptr<Recording>> open_file(const std::filesystem::path& path) {
  const Result<std::string> beginning = beginning_of(path);
  if (!beginning) return tl::unexpected(beginning.error());
  if (beginning->empty()) return invalid_input(path.string() + ": empty file");
  if (is_carmen_log(*beginning)) return open_carmen_recording(path);
  if (is_rawlog(*beginning)) return open_rawlog_recording(path);
  return invalid_input(path.string() + ": not a known recording (known: " + kKnownFormats + ")");
}

Result<std::unique_ptr<Recording>> open_folder(const std::filesystem::path& path) {
  if (is_euroc_folder(path)) return open_euroc_recording(path);
  if (is_image_folder(path)) return open_image_folder_recording(path);
  std::error_code code;
  if (std::filesystem::exists(path / "sensor.yaml", code)) {
    return invalid_input(path.string() + ": one sensor of an EuRoC/ASL folder (open the folder that holds it)");
  }
  return invalid_input(path.string() + ": not a known recording (known: " + kKnownFormats + ")");
}

}  // namespace

Result<std::unique_ptr<Recording>> open_recording(const std::filesystem::path& path, const RecordingOptions& options) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) return invalid_input(path.string() + ": no such file or folder");
  if (is_ros_bag(path)) {
    Result<std::unique_ptr<RosBag>> bag = open_bag(path);
    if (!bag) return tl::unexpected(bag.error());
    return open_ros_recording(std::move(*bag), path, options);
  }
  Result<std::unique_ptr<Recording>> recording =
      std::filesystem::is_directory(status) ? open_folder(path) : open_file(path);
  if (recording && !options.empty()) {
    return usage_error(path.string() + ": not a ROS bag, so it has no topics and frames to choose");
  }
  return recording;
}

bool is_ros_bag(const std::filesystem::path& path) {
  std::error_code code;
  if (std::filesystem::is_directory(path, code)) return is_ros2_bag_folder(path);
  const Result<std::string> beginning = beginning_of(path);
  return beginning && (is_ros1_bag(*beginning) || is_mcap_file(*beginning) || is_sqlite_file(*beginning));
}

Result<Trajectory2> read_ground_truth(const std::filesystem::path& path, const RecordingOptions& options) {
  if (is_ros_bag(path)) {
    Result<std::unique_ptr<RosBag>> bag = open_bag(path);
    if (!bag) return tl::unexpected(bag.error());
    return read_ros_ground_truth(**bag, options);
  }
  if (is_euroc_folder(path)) return read_euroc_ground_truth(path);
  return read_carmen_ground_truth(path);
}

}  // namespace slamfuse::common
