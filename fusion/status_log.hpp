// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "fusion/status.hpp"

namespace slamfuse::fusion {

/// Thins verdicts to what status.csv shows: a row for each source when its state changes, else one an interval.
class StatusLog {
 public:
  explicit StatusLog(common::Nanoseconds interval) : interval_(interval) {}

  /// Appends `entry` to `rows` if it is due.
  void write(StatusEntry entry, std::vector<StatusEntry>& rows) {
    const auto last = last_.find(entry.source);
    if (last != last_.end() && last->second.state == entry.state && entry.stamp - last->second.stamp < interval_) {
      return;
    }
    last_[entry.source] = {entry.stamp, entry.state};
    rows.push_back(std::move(entry));
  }

 private:
  struct Written {
    common::Nanoseconds stamp = 0;
    Verdict state = Verdict::kTracking;
  };

  common::Nanoseconds interval_;
  std::map<common::PoseSource, Written> last_;
};

}  // namespace slamfuse::fusion
