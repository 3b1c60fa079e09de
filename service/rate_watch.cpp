// SPDX-License-Identifier: BSD-3-Clause
#include "service/rate_watch.hpp"

namespace slamfuse::service {
namespace {

using Seconds = std::chrono::duration<double>;

/// From the first message [s].
constexpr double kLearning = 5.0;
/// In so many messages a rate shows.
constexpr double kEnough = 5.0;
/// Counts older than that tell nothing new [s].
constexpr double kRemembered = 20.0;
constexpr double kUnusual = 3.0;

}  // namespace

double RateWatch::between(const Count& from, const Count& to) {
  return static_cast<double>(to.received - from.received) / Seconds(to.at - from.at).count();
}

void RateWatch::look(Time now, std::size_t received) {
  if (!counts_.empty() && now <= counts_.back().at) return;
  const Count count{now, received};
  if (!counts_.empty() && received > counts_.back().received) {
    constexpr double kNewest = 0.3;  // of the smoothed rate
    const double rate = between(counts_.back(), count);
    smoothed_ = smoothed_ == 0.0 ? rate : (1.0 - kNewest) * smoothed_ + kNewest * rate;
  }
  // A topic that has not begun yet is no slow one.
  if (!usual_ && !counts_.empty() && received == counts_.front().received) counts_.clear();
  counts_.push_back(count);
  const bool learnt = Seconds(now - counts_.front().at).count() >= kLearning &&
                      static_cast<double>(received - counts_.front().received) >= kEnough;
  if (!usual_ && learnt) usual_ = between(counts_.front(), count);
  while (usual_ && Seconds(now - counts_.front().at).count() > kRemembered) counts_.pop_front();
}

std::optional<double> RateWatch::unusual() const {
  if (!usual_ || counts_.empty()) return std::nullopt;
  const Count& now = counts_.back();
  for (auto from = counts_.rbegin() + 1; from != counts_.rend(); ++from) {
    if (*usual_ * Seconds(now.at - from->at).count() < kEnough) continue;
    const double rate = between(*from, now);
    if (rate * kUnusual < *usual_ || rate > *usual_ * kUnusual) return rate;
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace slamfuse::service
