// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/submap.hpp"

#include <optional>

#include <Eigen/LU>

#include "laser_slam/motion_model.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr double kBelieved = 0.4;      // agreement with the submap below which a match tells nothing
constexpr double kBrokenChain = 0.01;  // [1/m^2, 1/rad^2] information between keyframes no motion connects

/// The submaps that grow, the older one first, and where they lie in the local frame.
class Growth {
 public:
  Growth(LocalMapping& result, const MapOptions& map_options, int submap_scans)
      : result_(result), map_options_(map_options), full_(static_cast<std::size_t>(submap_scans)) {}

  bool empty() const { return active_.empty(); }
  const GridMap& map() const { return result_.submaps[static_cast<std::size_t>(active_.front().index)].map; }
  /// T_local_submap of the map that is matched in.
  const common::Pose2& frame() const { return active_.front().frame; }

  void close() { active_.clear(); }

  /// Draws a keyframe at `local`, its pose in the local frame.
  void draw(int keyframe, const ScanBeams& scan, double path_length, const common::Pose2& local) {
    const bool begin = active_.empty() || (active_.size() == 1 && size(active_.front()) * 2 >= full_);
    if (begin) {
      active_.push_back({static_cast<int>(result_.submaps.size()), local});
      result_.submaps.push_back({GridMap(map_options_), {}});
    }
    for (const Active& active : active_) {
      Submap& submap = result_.submaps[static_cast<std::size_t>(active.index)];
      submap.map.insert(scan, active.frame.inverse() * local, path_length, scratch_);
      submap.members.push_back(keyframe);
    }
    if (size(active_.front()) >= full_) active_.erase(active_.begin());
  }

  /// A keyframe belongs to the growing submaps where it was found in them.
  void tie(int keyframe, const common::Pose2& local, const Eigen::Matrix3d& information) {
    for (const Active& active : active_) {
      // The information is in the local frame; that of a submap is turned against it.
      const common::Pose2 back{0.0, 0.0, -active.frame.theta};
      result_.memberships.push_back(
          {active.index, keyframe, active.frame.inverse() * local, to_parent_frame(information, back), false});
    }
  }

 private:
  struct Active {
    int index;
    common::Pose2 frame;
  };
  std::size_t size(const Active& active) const {
    return result_.submaps[static_cast<std::size_t>(active.index)].members.size();
  }

  LocalMapping& result_;
  MapOptions map_options_;
  std::size_t full_;
  std::vector<Active> active_;
  InsertionScratch scratch_;
};

struct LocalMatch {
  common::Pose2 pose;  // in the local frame
  ScanFit fit;         // its information turned into the local frame
  const MotionSinceUpdate* motion;
};

/// The likeliest of what the motions lead to.
LocalMatch match_locally(const Growth& growth, const ScanMatcher& matcher, const ScanBeams& scan,
                         const common::Pose2& last, const std::vector<MotionSinceUpdate>& motions) {
  std::optional<LocalMatch> best;
  for (const MotionSinceUpdate& motion : motions) {
    const common::Pose2 back = growth.frame().inverse();
    const common::Pose2 mean = back * last * motion.increment;
    const PosePrior prior{mean, to_parent_frame(motion.covariance, mean).inverse()};
    ScanMatch match = matcher.match(growth.map(), scan.match_points, back * last * motion.guess, prior);
    if (best && match.fit.log_likelihood <= best->fit.log_likelihood) continue;
    match.fit.information = to_parent_frame(match.fit.information, {0.0, 0.0, growth.frame().theta});
    best = LocalMatch{growth.frame() * match.pose, match.fit, &motion};
  }
  if (best->fit.agreement < kBelieved) {
    // Nothing fits: the prediction alone tells, without the match that the filter may have followed.
    best->motion = &motions.back();
    best->pose = last * best->motion->increment;
    best->fit.information.setZero();
  }
  return *best;
}

}  // namespace

LocalMapping map_locally(const std::vector<Keyframe>& keyframes, const std::vector<common::Pose2>& poses,
                         const ScanMatcher& matcher, const MapOptions& map_options, int submap_scans) {
  LocalMapping result;
  Growth growth(result, map_options, submap_scans);
  common::Pose2 local;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const Keyframe& keyframe = keyframes[i];
    const int index = static_cast<int>(i);
    const ScanBeams scan = keyframe.scan.restore();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    if (keyframe.motions.empty()) {
      growth.close();
      local = poses[i];
      if (i > 0) {
        result.motions.push_back(
            {index - 1, index, poses[i - 1].inverse() * poses[i], kBrokenChain * Eigen::Matrix3d::Identity(), false});
      }
    } else {
      const MotionSinceUpdate* motion = &keyframe.motions.back();
      if (growth.empty()) {
        local = local * motion->increment;
      } else {
        const LocalMatch match = match_locally(growth, matcher, scan, local, keyframe.motions);
        motion = match.motion;
        local = match.pose;
        information = matcher.gain() * match.fit.information;
        growth.tie(index, local, information);
      }
      result.motions.push_back({index - 1, index, motion->increment,
                                to_parent_frame(motion->covariance, motion->increment).inverse(), false});
    }
    if (!keyframe.mapped || keyframe.scan.empty()) continue;
    const std::size_t before = result.submaps.size();
    growth.draw(index, scan, keyframe.path_length, local);
    if (result.submaps.size() > before) {
      // It is the submap's origin.
      constexpr double kFixed = 1e6;  // [1/m^2, 1/rad^2]: 1 mm
      result.memberships.push_back({static_cast<int>(before), index, {}, kFixed * Eigen::Matrix3d::Identity(), false});
    }
  }
  return result;
}

}  // namespace slamfuse::laser_slam
