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
#include "common/look_ahead.hpp"
#include "common/rawlog_guard.hpp"

namespace slamfuse::common {
namespace {

/// Bytes in a string and things in an array that MRPT is let make room for.
constexpr std::size_t kMostInObject = std::size_t{1} << 24;
/// Bytes that MRPT may ask for at once, of pictures above all.
constexpr std::size_t kMostAtOnce = std::size_t{1} << 28;

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

/// MRPT copies a truth value from the file as it is, which may be neither 0 nor 1.
bool is_true(const bool& from_file) {
  unsigned char byte = 0;
  std::memcpy(&byte, &from_file, sizeof(byte));
  return byte != 0;
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
  const bool right_to_left = is_true(scan.rightToLeft);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = right_to_left ? i : count - 1 - i;
    result.readings.push_back(double{scan.getScanRange(at)});
    result.valid.push_back(scan.getScanRangeValidity(at));
  }
  return result;
}

RawlogOdometry odometry_from(const mrpt::obs::CObservationOdometry& odometry) {
  RawlogOdometry result{stamp_from(odometry.timestamp), pose_from(odometry.odometry)};
  if (is_true(odometry.hasVelocities)) {
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
  if (is_true(movement->hasVelocities)) {
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

}  // namespace

/// What MRPT reads its serialised objects from: our decompressed bytes. Tells data that ends between two objects from
/// data that is damaged or ends within one.
///
/// MRPT reads the length of a string or an array like any other number and makes room for so much before it reads on.
/// So an object is first read with every number of four bytes that is more than the bytes to come replaced by their
/// count. Where such a number was a length, so much is asked for next, and the file is refused. Where it was a reading
/// or an angle, nothing of how the object is built depends on it, and the object is read once more as it is.
class RawlogEntries::Archive final : public mrpt::serialization::CArchive {
 public:
  explicit Archive(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {}

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
  /// Replaces a number that may be a length for which the file is too short.
  void limit(char* number);
  [[noreturn]] void fail(const std::string& reason);

  LookAhead source_;
  RawlogGuard guard_;
  bool object_begun_ = false;
  bool ended_between_objects_ = false;
  bool trying_ = false;       ///< numbers are replaced
  bool replaced_ = false;     ///< one was, in this object
  std::size_t limit_ = 0;     ///< that stands for the number just read; 0: none was replaced
  std::uint32_t number_ = 0;  ///< what it was
  std::string failure_;
};

mrpt::serialization::CSerializable::Ptr RawlogEntries::Archive::read_object() {
  object_begun_ = false;
  ended_between_objects_ = false;
  replaced_ = false;
  limit_ = 0;
  source_.set_mark();
  guard_ = {};
  trying_ = true;
  mrpt::serialization::CSerializable::Ptr object;
  try {
    object = ReadObject();
  } catch (const std::exception&) {
    if (ended_between_objects_) return nullptr;
    throw;
  }
  if (!replaced_) return object;
  trying_ = false;
  guard_ = {};
  source_.return_to_mark();
  return ReadObject();
}

size_t RawlogEntries::Archive::read(void* buffer, size_t length) {
  if (limit_ > 0 && length > 0 && length % limit_ == 0) {
    fail("an object says it holds " + std::to_string(number_) + " things or more, with " + std::to_string(limit_) +
         (limit_ == kMostInObject ? " allowed" : " bytes left in the file"));
  }
  limit_ = 0;
  if (length > kMostAtOnce) fail("an object says it holds " + std::to_string(length) + " bytes in a piece");
  char* bytes = static_cast<char*>(buffer);
  if (source_.available(length) < length) {
    ended_between_objects_ = !object_begun_ && source_.available(1) == 0 && !source_.failure();
    fail(source_.failure() ? source_.failure()->message : "the file ends in the middle of an entry");
  }
  source_.take(bytes, length);
  object_begun_ = true;
  if (length == 0) return length;
  if (const std::string flaw = guard_.flaw_of({bytes, length}); !flaw.empty()) fail(flaw);
  if (trying_ && length == sizeof(number_)) limit(bytes);
  return length;
}

void RawlogEntries::Archive::limit(char* number) {
  std::memcpy(&number_, number, sizeof(number_));
  const std::size_t most = source_.available(std::min<std::size_t>(number_, kMostInObject));
  if (number_ <= most) return;
  replaced_ = true;
  limit_ = most;
  const auto instead = static_cast<std::uint32_t>(most);
  std::memcpy(number, &instead, sizeof(instead));
}

size_t RawlogEntries::Archive::write(const void* /*buffer*/, size_t /*length*/) {
  throw std::logic_error("this archive is only read");
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
