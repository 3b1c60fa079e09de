// SPDX-License-Identifier: BSD-3-Clause
#include "service/rate_watch.hpp"

#include <algorithm>

namespace slamfuse::service {
namespace {

using Seconds = std::chrono::duration<double>;

/// Looks with messages from which the usual rate is learnt.
constexpr std::size_t kLearning = 5;
/// In so many messages a rate shows.
constexpr double kEnough = 5.0;
/// What is longer ago tells nothing new.
constexpr std::chrono::seconds kRemembered{20};
constexpr double kUnusual = 3.0;

}  // namespace

double RateWatch::between(const Count& from, const Count& to) {
  return static_cast<double>(to.received - from.received) / Seconds(to.at - from.at).count();
}

bool RateWatch::is_steady() const {
  if (heard_.size() <= kLearning) return false;
  double slowest = between(heard_[0], heard_[1]);
  double fastest = slowest;
  for (std::size_t i = 2; i < heard_.size(); ++i) {
    const double rate = between(heard_[i - 1], heard_[i]);
    slowest = std::min(slowest, rate);
    fastest = std::max(fastest, rate);
  }
  return fastest <= kUnusual * slowest;
}

void RateWatch::look(Time now, std::size_t received) {
  if (!counts_.empty() && now <= counts_.back().at) return;
  const Count count{now, received};
  counts_.push_back(count);
  while (counts_.size() > 1 && now - counts_[1].at >= kRemembered) counts_.pop_front();

  if (heard_.empty() || received == heard_.back().received) {
    if (heard_.size() < 2) heard_.assign(1, count);  // a topic that has not begun yet is no slow one
    return;
  }
  heard_.push_back(count);
  if (heard_.size() > kLearning + 1) heard_.pop_front();
  constexpr double kNewest = 0.3;  // of the smoothed rate
  const double rate = between(heard_[heard_.size() - 2], count);
  smoothed_ = smoothed_ == 0.0 ? rate : (1.0 - kNewest) * smoothed_ + kNewest * rate;
  if (!usual_ && is_steady()) usual_ = between(heard_.front(), heard_.back());
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
