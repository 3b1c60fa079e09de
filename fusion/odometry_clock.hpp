// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "common/time.hpp"

namespace slamfuse::fusion {

/// Watches the stamps of odometry for times that do not count: a moment without any input is a gap in a log (CARMEN's
/// write in bursts) or a program that slept, and no silence of the halves; a clock that steps back takes nothing back.
class OdometryClock {
 public:
  /// A pose of a half has come.
  void heard(common::Nanoseconds stamp);
  /// Takes the stamp of the next odometry message. Returns by how much the stamps of all that was said before are to be
  /// shifted.
  common::Nanoseconds next(common::Nanoseconds stamp);

 private:
  std::optional<common::Nanoseconds> last_;
  std::optional<common::Nanoseconds> usual_gap_;  ///< slowly following, without the long ones
  bool spoke_in_gap_ = false;                     ///< a pose is of a time after the last message
  bool paused_ = false;                           ///< since a half has last spoken
};

}  // namespace slamfuse::fusion
