// SPDX-License-Identifier: BSD-3-Clause
#include "common/rawlog_entries.hpp"

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "common/angle.hpp"
#include "common/byte_source.hpp"

namespace slamfuse::common {
namespace {

/// MRPT counts 100 ns since 1601; 0 stands for no stamp.
std::optional<Nanoseconds> stamp_from(const mrpt::Clock::time_point& time) {
  constexpr std::int64_t kTicksFrom1601To1970 = 116'444'736'000'000'000;
  constexpr std::int64_t kNanosecondsPerTick = 100;
  constexpr std::int64_t kLatestTicks = kTicksFrom1601To1970 + kLatestStamp / kNanosecondsPerTick;
  const std::int64_t ticks = time.time_since_epoch().count();
  if (ticks < kTicksFrom1601To1970 || ticks > kLatestTicks) return std::nullopt;
  return (ticks - kTicksFrom1601To1970) * kNanosecondsPerTick;
}

Pose2 pose_from(const mrpt::poses::CPose2D& pose) { return {pose.x(), pose.y(), normalize_angle(pose.phi())}; }

Pose3 pose_from(const mrpt::poses::CPose3D& pose) {
  const Eigen::Matrix3d rotation = pose.getRotationMatrix().asEigen();
  return {{pose.x(), pose.y(), pose.z()}, Eigen::Quaterniond(rotation).normalized()};
}

RawlogScan scan_from(const mrpt::obs::CObservation2DRangeScan& scan) {
  const std::size_t count = scan.getScanSize();
  RawlogScan result;
  result.stamp = stamp_from(scan.timestamp);
  result.label = scan.sensorLabel;
  result.geometry.T_base_laser = pose_from(scan.sensorPose);
  result.geometry.beams = static_cast<int>(count);
  result.geometry.angle_min = -0.5 * double{scan.aperture};
  result.geometry.angle_increment = count > 1 ? double{scan.aperture} / static_cast<double>(count - 1) : 0.0;
  result.geometry.range_max = double{scan.maxRange};
  result.readings.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = scan.rightToLeft ? i : count - 1 - i;
    result.readings.push_back(double{scan.getScanRange(at)});
    result.valid.push_back(scan.getScanRangeValidity(at));
  }
  return result;
}

RawlogOdometry odometry_from(const mrpt::obs::CObservationOdometry& odometry) {
  RawlogOdometry result{stamp_from(odometry.timestamp), pose_from(odometry.odometry)};
  if (odometry.hasVelocities) {
    result.forward_speed = odometry.velocityLocal.vx;
    result.turn_rate = odometry.velocityLocal.omega;
  }
  return result;
}

void add_observation(const mrpt::obs::CObservation& observation, RawlogObservations& entry) {
  if (const auto* scan = dynamic_cast<const mrpt::obs::CObservation2DRangeScan*>(&observation)) {
    entry.observations.emplace_back(scan_from(*scan));
  } else if (const auto* odometry = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&observation)) {
    entry.observations.emplace_back(odometry_from(*odometry));
  }
}

/// Empty when the action holds no odometry.
std::optional<RawlogAction> action_from(mrpt::obs::CActionCollection& actions) {
  const auto movement = actions.getMovementEstimationByType(mrpt::obs::CActionRobotMovement2D::emOdometry);
  if (!movement) return std::nullopt;
  RawlogAction action{pose_from(movement->rawOdometryIncrementReading)};
  if (movement->hasVelocities) {
    action.forward_speed = movement->velocityLin();
    action.turn_rate = movement->velocityAng();
  }
  return action;
}

/// Of an object of no interest an entry without observations, so that entries can be counted.
RawlogEntry entry_from(const mrpt::serialization::CSerializable::Ptr& object) {
  RawlogObservations entry;
  if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
    if (const std::optional<RawlogAction> action = action_from(*actions)) return *action;
  } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
    entry.is_frame = true;
    for (const mrpt::obs::CObservation::Ptr& observation : *frame) {
      if (observation) add_observation(*observation, entry);
    }
  } else if (const auto observation = std::dynamic_pointer_cast<mrpt::obs::CObservation>(object)) {
    add_observation(*observation, entry);
  }
  return entry;
}

/// What an exception says, without the place in MRPT's sources and the call stack that MRPT adds.
std::string told_by(const std::exception& error) {
  const std::string_view text = error.what();
  constexpr std::string_view kLabel = "Message:";
  const std::size_t label = text.find(kLabel);
  const std::size_t begin = label == std::string_view::npos ? 0 : text.find_first_not_of(' ', label + kLabel.size());
  return std::string(text.substr(std::min(begin, text.size()), text.find('\n', begin) - begin));
}

/// A frame holds the observations of one moment. MRPT makes room for as many as the file says before it reads one.
constexpr std::uint32_t kMostInFrame = 10'000;
constexpr std::string_view kFrameClass = "CSensoryFrame";  // in whatever namespace: MRPT takes old names without, too

}  // namespace

/// What MRPT reads its serialised objects from: our decompressed bytes. Tells data that ends between two objects from
/// data that is damaged or ends within one.
class RawlogEntries::Archive final : public mrpt::serialization::CArchive {
 public:
  explicit Archive(std::unique_ptr<ByteSource> source);

  /// The next object; null when the data ends just before one. Throws std::exception when the data is damaged, ends
  /// within an object, or holds an object of a kind MRPT does not know.
  mrpt::serialization::CSerializable::Ptr read_object();

  /// Why the data could not be read on within an object; empty when MRPT itself refused what it read.
  const std::string& failure() const { return failure_; }

  std::string getArchiveDescription() const override { return "rawlog"; }

 protected:
  size_t read(void* buffer, size_t length) override;
  size_t write(const void* buffer, size_t length) override;

 private:
  void fill();
  void check_frame(std::string_view just_read);
  [[noreturn]] void fail(const std::string& reason);

  std::unique_ptr<ByteSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;  ///< of the unread bytes in buffer_
  std::size_t end_ = 0;
  bool object_begun_ = false;
  bool frame_begun_ = false;  ///< the name of a frame was read, its number of observations was not
  bool ended_between_objects_ = false;
  std::string failure_;
};

RawlogEntries::Archive::Archive(std::unique_ptr<ByteSource> source) : source_(std::move(source)), buffer_(1U << 16) {}

mrpt::serialization::CSerializable::Ptr RawlogEntries::Archive::read_object() {
  object_begun_ = false;
  ended_between_objects_ = false;
  try {
    return ReadObject();
  } catch (const std::exception&) {
    if (ended_between_objects_) return nullptr;
    throw;
  }
}

size_t RawlogEntries::Archive::read(void* buffer, size_t length) {
  std::size_t size = 0;
  while (size < length) {
    if (begin_ == end_) fill();
    if (begin_ == end_) {
      ended_between_objects_ = !object_begun_ && size == 0;
      fail("the file ends in the middle of an entry");
    }
    const std::size_t count = std::min(length - size, end_ - begin_);
    std::memcpy(static_cast<char*>(buffer) + size, buffer_.data() + begin_, count);
    begin_ += count;
    size += count;
  }
  object_begun_ = true;
  check_frame({static_cast<const char*>(buffer), size});
  return size;
}

size_t RawlogEntries::Archive::write(const void* /*buffer*/, size_t /*length*/) {
  throw std::logic_error("this archive is only read");
}

void RawlogEntries::Archive::fill() {
  const Result<std::size_t> count = source_->read(buffer_);
  if (!count) {
    object_begun_ = true;  // damaged, even if between two objects
    fail(count.error().message);
  }
  begin_ = 0;
  end_ = *count;
}

/// Behind a frame's name come its version, in old ones a stamp of 8 bytes, and the number of its observations.
void RawlogEntries::Archive::check_frame(std::string_view just_read) {
  std::uint32_t count = 0;
  if (just_read.substr(just_read.rfind(':') + 1) == kFrameClass) {
    frame_begun_ = true;
  } else if (frame_begun_ && just_read.size() == sizeof(count)) {
    frame_begun_ = false;
    std::memcpy(&count, just_read.data(), sizeof(count));
    if (count > kMostInFrame) fail("a frame says it holds " + std::to_string(count) + " observations");
  }
}

/// Keeps the reason, because MRPT throws another exception on the way up.
void RawlogEntries::Archive::fail(const std::string& reason) {
  failure_ = reason;
  throw std::runtime_error(reason);
}

RawlogEntries::RawlogEntries(std::unique_ptr<Archive> archive) : archive_(std::move(archive)) {}
RawlogEntries::RawlogEntries(RawlogEntries&&) noexcept = default;
RawlogEntries& RawlogEntries::operator=(RawlogEntries&&) noexcept = default;
RawlogEntries::~RawlogEntries() = default;

Result<RawlogEntries> RawlogEntries::open(const std::filesystem::path& path) {
  Result<std::unique_ptr<ByteSource>> source = open_byte_source(path);
  if (!source) return tl::unexpected(source.error());
  return RawlogEntries(std::make_unique<Archive>(std::move(*source)));
}

Result<std::optional<RawlogEntry>> RawlogEntries::next() try {
  const mrpt::serialization::CSerializable::Ptr object = archive_->read_object();
  if (!object) return std::nullopt;
  return entry_from(object);
} catch (const std::exception& error) {
  return invalid_input("damaged, cut short or of a kind MRPT does not know, nothing behind it can be read: " +
                       (archive_->failure().empty() ? told_by(error) : archive_->failure()));
}

}  // namespace slamfuse::common
