// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "common/error.hpp"
#include "common/recording.hpp"

namespace slamfuse::common {

/// How a recording is played. All times in seconds; sensors by name.
struct ReplayOptions {
  double from = 0.0;                            ///< [s] after the recording's start; earlier messages are left out
  std::optional<double> to;                     ///< [s] after the recording's start; later messages are left out
  std::map<std::string, double> arrival_delay;  ///< [s] 0 to 60: messages come that much later, stamps stay true
  std::set<std::string> only_sensors;           ///< messages of others are left out, rejected ones too; empty: none are
  std::map<std::string, double> stamp_offset;   ///< [s] added to the stamps: falsifies them, the order stays
  /// [s] how long a laser's sweep takes, where the recording does not tell or tells wrong; 0: instantaneous. Negative:
  /// the beam that stands last is fired first, so ranges and bearings come in reverse.
  std::map<std::string, double> sweep_duration;
};

/// The recording as these options play it. Its info() is that of the recording, with the stamps moved by the offsets,
/// the sweep durations set and the time span cut to from and to; message counts stay those of the whole recording.
///
/// Order: the arrival time of a message is its true stamp plus its sensor's delay, in a recording that is not ordered
/// by stamp the largest true stamp so far plus the delay. Messages come by arrival time, those of equal arrival time in
/// their original order. Rejected messages are treated like messages. Memory holds as many messages as arrive within
/// the largest delay.
///
/// Errors (kUsage): a sensor that the recording does not have (the message names those it has), a delay outside 0 to
/// 60, an offset outside -3600 to 3600, a sweep outside -60 to 60 or of a sensor that is no laser, `from` negative or
/// not before `to`, a number that is not finite.
Result<std::unique_ptr<Recording>> replay(std::unique_ptr<Recording> recording, const ReplayOptions& options);

}  // namespace slamfuse::common
