// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/estimate_judge.hpp"

#include <utility>

#include <fmt/format.h>

namespace slamfuse::visual_slam {
namespace {

constexpr common::Nanoseconds kLoopEventInterval = 10 * common::kNanosecondsPerSecond;

}  // namespace

common::Event visual_event(common::Nanoseconds stamp, std::string kind, std::string detail) {
  return {.stamp = stamp, .module = "visual", .kind = std::move(kind), .detail = std::move(detail)};
}

EstimateJudge::EstimateJudge(const VisualSlamOptions& options)
    : options_(options.tracking),
      recognition_(options.recognition),
      by_wheels_(options.motion.model == MotionModelKind::kOdometry),
      monitor_(options.tracking),
      trust_(options.tracking.min_inliers) {}

void EstimateJudge::clear() {
  monitor_ = TrackingMonitor(options_);
  trust_.end();
  last_loop_.reset();
}

bool EstimateJudge::doubts(const Ekf& filter, const LandmarkBook& book, const std::vector<Track>& tracks,
                           const UpdateReport& report, common::Nanoseconds stamp, std::vector<common::Event>& events) {
  if (!by_wheels_) return false;
  if (report.wheels == SlipWatch::Verdict::kSlip) {
    events.push_back(visual_event(stamp, "wheel_slip", "the camera does not see what the wheel odometry says"));
  }
  if (report.wheels == SlipWatch::Verdict::kGrip) {
    events.push_back(visual_event(stamp, "wheel_grip", "they agree again"));
  }
  std::vector<LandmarkId> known;
  for (const Track& track : tracks) {
    if (filter.is_cartesian(track.landmark)) known.push_back(track.landmark);
  }
  const bool doubtful = filter.odometry_is_doubtful();
  if (doubtful) trust_.begin(book.known(filter));
  if (trust_.see(known) && !doubtful) trust_.end();
  return trust_.is_watching();
}

bool EstimateJudge::judge(common::Nanoseconds stamp, const ImageEvidence& evidence,
                          std::vector<common::Event>& events) {
  const common::TrackingState before = monitor_.state();
  const common::TrackingState now = monitor_.update(stamp, evidence);
  const std::string figures = fmt::format("{} features accepted of {} expected", evidence.inliers, evidence.expected);
  const bool lost_now = now == common::TrackingState::kLost && before != now;
  if (lost_now) events.push_back(visual_event(stamp, "lost", figures));
  if (before == common::TrackingState::kLost && now == common::TrackingState::kTracking) {
    events.push_back(visual_event(stamp, "relocalised", figures));
  }
  return lost_now;
}

void EstimateJudge::tell_loop(int back_after_long, common::Nanoseconds stamp, std::vector<common::Event>& events) {
  if (back_after_long < recognition_.loop_landmarks) return;
  if (last_loop_ && stamp - *last_loop_ <= kLoopEventInterval) return;
  last_loop_ = stamp;
  events.push_back(visual_event(
      stamp, "loop_closed",
      fmt::format("{} landmarks recognised after more than {} s", back_after_long, recognition_.loop_absence)));
}

}  // namespace slamfuse::visual_slam
