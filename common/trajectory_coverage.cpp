// SPDX-License-Identifier: BSD-3-Clause
#include "common/trajectory_coverage.hpp"

#include <algorithm>
#include <vector>

namespace slamfuse::common {
namespace {

/// A stretch of time, begin <= end.
struct Interval {
  Nanoseconds begin;
  Nanoseconds end;
};

/// Appends an interval that begins no earlier than the last one, joining the two where they touch.
void append(std::vector<Interval>& intervals, Interval next) {
  if (!intervals.empty() && next.begin <= intervals.back().end) {
    intervals.back().end = std::max(intervals.back().end, next.end);
  } else {
    intervals.push_back(next);
  }
}

std::vector<Interval> covered_by(const Trajectory2& estimate) {
  std::vector<Interval> intervals;
  for (const StampedPose2& pose : sorted_by_stamp(estimate)) {
    append(intervals, {pose.stamp, pose.stamp + kCoveredByPose});
  }
  return intervals;
}

std::vector<Interval> times_with_reference(const Trajectory2& reference) {
  std::vector<Interval> intervals;
  for (std::size_t i = 1; i < reference.size(); ++i) {
    const Interval step{reference[i - 1].stamp, reference[i].stamp};
    if (step.end - step.begin <= kReferenceHole) append(intervals, step);
  }
  return intervals;
}

/// Length of the time that lies in both.
Nanoseconds overlap(const std::vector<Interval>& a, const std::vector<Interval>& b) {
  Nanoseconds total = 0;
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    total += std::max<Nanoseconds>(0, std::min(a[i].end, b[j].end) - std::max(a[i].begin, b[j].begin));
    if (a[i].end < b[j].end) {
      ++i;
    } else {
      ++j;
    }
  }
  return total;
}

double share_of_poses_covered(const std::vector<Interval>& covered, const Trajectory2& reference) {
  const auto count = std::count_if(reference.begin(), reference.end(), [&](const StampedPose2& pose) {
    const auto after = std::upper_bound(covered.begin(), covered.end(), pose.stamp,
                                        [](Nanoseconds stamp, const Interval& i) { return stamp < i.begin; });
    return after != covered.begin() && pose.stamp <= std::prev(after)->end;
  });
  return static_cast<double>(count) / static_cast<double>(reference.size());
}

}  // namespace

bool is_sparse(const Trajectory2& reference) {
  std::size_t holes = 0;
  for (std::size_t i = 1; i < reference.size(); ++i) {
    if (reference[i].stamp - reference[i - 1].stamp > kReferenceHole) ++holes;
  }
  return reference.size() < 2 || 2 * holes > reference.size() - 1;
}

double trajectory_coverage(const Trajectory2& estimate, const Trajectory2& reference) {
  if (reference.empty()) return 0.0;
  const std::vector<Interval> covered = covered_by(estimate);
  if (is_sparse(reference)) return share_of_poses_covered(covered, reference);
  const std::vector<Interval> known = times_with_reference(reference);
  Nanoseconds total = 0;
  for (const Interval& interval : known) total += interval.end - interval.begin;
  return static_cast<double>(overlap(covered, known)) / static_cast<double>(total);
}

double time_coverage(const Trajectory2& estimate, Nanoseconds first, Nanoseconds last) {
  const std::vector<Interval> covered = covered_by(estimate);
  if (last <= first) return share_of_poses_covered(covered, {{first, {}}});
  return static_cast<double>(overlap(covered, {{first, last}})) / static_cast<double>(last - first);
}

}  // namespace slamfuse::common
