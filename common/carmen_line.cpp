// SPDX-License-Identifier: BSD-3-Clause
#include "common/carmen_line.hpp"

#include <cstdint>
#include <numbers>
#include <string>

#include "common/angle.hpp"
#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

constexpr std::size_t kFewestReadings = 2;
constexpr std::size_t kMostReadings = 100'000;

/// Takes the words of a line one after the other. The first word that does not fit is kept as the error and everything
/// after it reads as 0, so a parser needs to look for an error only once, at its end.
class WordReader {
 public:
  explicit WordReader(std::span<const std::string_view> words) : words_(words) {}

  double number() {
    const std::string_view word = next();
    const std::optional<double> value = parse_real(word);
    if (!value) refuse(word, "a finite number");
    return value.value_or(0.0);
  }

  std::size_t count(std::size_t least, std::size_t most) {
    const std::string_view word = next();
    const std::optional<std::int64_t> value = parse_integer(word);
    const bool fits = value && *value >= static_cast<std::int64_t>(least) && *value <= static_cast<std::int64_t>(most);
    if (!fits) refuse(word, "a count from " + std::to_string(least) + " to " + std::to_string(most));
    return fits ? static_cast<std::size_t>(*value) : 0;
  }

  Nanoseconds stamp() {
    const std::string_view word = next();
    const std::optional<Nanoseconds> value = parse_decimal_seconds(word);
    const bool fits = value && *value >= 0;
    if (!fits) refuse(word, "a stamp in decimal seconds");
    return fits ? *value : 0;
  }

  Pose2 pose() {
    Pose2 pose;
    pose.x = number();
    pose.y = number();
    pose.theta = normalize_angle(number());
    return pose;
  }

  std::vector<double> readings(std::size_t count) {
    std::vector<double> values;
    if (count > words_.size() - at_) refuse_length("fewer");
    for (std::size_t i = 0; i < count && problem_.empty(); ++i) {
      const std::string_view word = words_[at_];
      values.push_back(number());
      if (values.back() < 0.0) refuse(word, "a range of 0 or more");
    }
    return values;
  }

  void skip(std::size_t count) {
    for (std::size_t i = 0; i < count && problem_.empty(); ++i) next();
  }

  /// The error of the first word that did not fit, also of words left over.
  Result<void> finish() {
    if (problem_.empty() && at_ != words_.size()) refuse_length("more");
    if (!problem_.empty()) return invalid_input(problem_);
    return {};
  }

 private:
  std::string_view next() {
    if (at_ < words_.size()) return words_[at_++];
    refuse_length("fewer");
    return "0";
  }

  void refuse(std::string_view word, const std::string& allowed) {
    if (!problem_.empty()) return;
    problem_ = std::string(words_.front()) + " with " + in_quotes(word) + " as word " + std::to_string(at_) +
               " (allowed: " + allowed + ")";
  }

  void refuse_length(const std::string& fewer_or_more) {
    if (!problem_.empty()) return;
    problem_ = std::string(words_.front()) + " with " + std::to_string(words_.size()) + " words, " + fewer_or_more +
               " than its counts promise";
  }

  std::span<const std::string_view> words_;
  std::size_t at_ = 1;  ///< behind the keyword
  std::string problem_;
};

}  // namespace

Result<CarmenScan> parse_flaser(std::span<const std::string_view> words) {
  WordReader reader(words);
  CarmenScan scan;
  scan.readings = reader.readings(reader.count(kFewestReadings, kMostReadings));
  scan.laser_pose = reader.pose();
  scan.robot_pose = reader.pose();
  scan.stamp = reader.stamp();
  constexpr std::size_t kHostAndLoggerStamp = 2;
  reader.skip(kHostAndLoggerStamp);
  const Result<void> finished = reader.finish();
  if (!finished) return tl::unexpected(finished.error());
  return scan;
}

Result<CarmenScan> parse_robotlaser1(std::span<const std::string_view> words) {
  WordReader reader(words);
  CarmenScan scan;
  CarmenBeams beams;
  constexpr std::size_t kType = 1;
  constexpr std::size_t kAccuracyAndRemissionMode = 2;
  reader.skip(kType);
  beams.angle_min = reader.number();
  const double field_of_view = reader.number();
  beams.angle_increment = reader.number();
  beams.range_max = reader.number();
  reader.skip(kAccuracyAndRemissionMode);
  scan.readings = reader.readings(reader.count(kFewestReadings, kMostReadings));
  reader.skip(reader.count(0, kMostReadings));
  scan.laser_pose = reader.pose();
  scan.robot_pose = reader.pose();
  scan.forward_speed = reader.number();
  scan.turn_rate = reader.number();
  constexpr std::size_t kSafetyDistancesAndTurnAxis = 3;
  reader.skip(kSafetyDistancesAndTurnAxis);
  scan.stamp = reader.stamp();
  constexpr std::size_t kHostAndLoggerStamp = 2;
  reader.skip(kHostAndLoggerStamp);
  const Result<void> finished = reader.finish();
  if (!finished) return tl::unexpected(finished.error());

  constexpr double kFullTurn = 2.0 * std::numbers::pi;
  constexpr double kRounding = 1e-3;
  const double turn = beams.angle_increment * static_cast<double>(scan.readings.size() - 1);
  if (beams.angle_increment <= 0.0 || turn > kFullTurn * (1.0 + kRounding) || std::abs(beams.angle_min) > kFullTurn) {
    return invalid_input("ROBOTLASER1 with start angle " + std::to_string(beams.angle_min) + ", field of view " +
                         std::to_string(field_of_view) + ", resolution " + std::to_string(beams.angle_increment) +
                         " rad for " + std::to_string(scan.readings.size()) + " readings (allowed: one full turn)");
  }
  if (beams.range_max <= 0.0) {
    return invalid_input("ROBOTLASER1 with maximum range " + std::to_string(beams.range_max) + " (allowed: above 0)");
  }
  scan.beams = beams;
  return scan;
}

CarmenBeams flaser_beams(std::size_t readings, double range_max) {
  double degrees = 180.0 / static_cast<double>(readings - 1);
  if (readings == 180 || readings == 181) degrees = 1.0;
  if (readings == 360 || readings == 361) degrees = 0.5;
  return {to_radians(-90.0), to_radians(degrees), range_max};
}

}  // namespace slamfuse::common
