// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <optional>

namespace slamfuse::service {

/// Compares the rate of a topic with what it was when it first was steady. Whether a rate is right nobody tells; that
/// it has become another is what a broken driver, or a doubled one, looks like. Topics with fewer than five messages in
/// 20 s (0.25 Hz) are not judged.
class RateWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Learns how many messages had come at this time. Times rise.
  void look(Time now, std::size_t received);
  /// Forgets all, as when the publisher has gone: the next one may have another rate.
  void reset() { *this = {}; }

  /// In messages a second, smoothed over a few looks; 0 before the second look at which messages had come.
  double rate() const { return smoothed_; }
  /// The rate that is usual [1/s]: that of the first five looks in a row with messages whose rates are much the same,
  /// so that a driver may stutter as it starts. Nothing before it is known.
  std::optional<double> usual() const { return usual_; }
  /// The rate of the newest stretch [1/s], the shortest in which five messages were due, when it is less than a third
  /// or more than three times the usual one. In between lies what load on a machine or exposure makes of a rate.
  std::optional<double> unusual() const;

 private:
  struct Count {
    Time at;
    std::size_t received = 0;
  };
  static double between(const Count& from, const Count& to);
  /// Whether as many looks as make a rate usual had messages, at much the same rate.
  bool is_steady() const;

  std::deque<Count> counts_;  // of the newest looks
  std::deque<Count> heard_;   // of the last few at which messages had come, and of the one before the first message
  double smoothed_ = 0.0;
  std::optional<double> usual_;
};

}  // namespace slamfuse::service
