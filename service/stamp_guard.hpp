// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>

#include "common/time.hpp"

namespace slamfuse::service {

/// Judges the stamps of live messages. Stamps of one sensor must rise, and no stamp may be far ahead of all others: one
/// garbled stamp would make everything after it late. When a sensor's messages are refused for a second although their
/// stamps rise among themselves, it is the clock that has changed: then the new time is accepted.
class StampGuard {
 public:
  using Arrival = std::chrono::steady_clock::time_point;

  enum class Kind {
    kGood,
    kRefused,      ///< drop the message
    kClockJumped,  ///< good; the clock is now far ahead of what it was
    kSteppedBack,  ///< good, but what came before lies in the future: start anew
  };
  struct Verdict {
    Kind kind = Kind::kGood;
    std::string reason;  ///< unless good
  };

  /// Judges the stamp of a message of this sensor that arrived then.
  Verdict judge(const std::string& sensor, common::Nanoseconds stamp, Arrival arrival);
  /// Forgets all stamps, as after kSteppedBack.
  void reset();

 private:
  struct Refused {
    Arrival since;
    common::Nanoseconds last = 0;
  };
  struct Track {
    std::optional<common::Nanoseconds> last;
    std::optional<Refused> refused;
  };

  /// Whether the sensor insists on a time that was refused.
  static bool insists(Track& track, common::Nanoseconds stamp, Arrival arrival);

  std::map<std::string, Track> tracks_;
  std::optional<common::Nanoseconds> newest_;
};

}  // namespace slamfuse::service
