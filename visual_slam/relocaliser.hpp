// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "common/pose2.hpp"
#include "common/time.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/landmark_index.hpp"
#include "visual_slam/options.hpp"
#include "visual_slam/planar_pose.hpp"

namespace slamfuse::visual_slam {

/// What a camera shows at one moment.
struct Glimpse {
  common::Nanoseconds stamp = 0;
  common::Pose2 odometry;  ///< T_odom_base there
  const Camera* camera = nullptr;
  BodyTwist twist = {};      ///< of base_link there, as in make_bearing
  double lever_scale = 1.0;  ///< units of the map a metre is
};

/// A pose that was found without knowing where to look.
struct Relocalisation {
  common::Pose2 pose;  ///< T_map_base at the newest glimpse
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  int landmarks = 0;  ///< different ones that agree with it
  int runner_up = 0;  ///< that agree with the best pose elsewhere
  int images = 0;     ///< in which they were seen
};

/// Finds the pose of base_link in the whole map from one or a few images of any cameras.
///
/// The features of each image are matched with the landmark index. The matches of the last few seconds are referred to
/// the newest image by the odometry, so cameras and images count together, and each image confirms or refutes what the
/// ones before suggested. Poses through two matches drawn at random (RANSAC, seeded) and the best poses of the call
/// before are judged by the number of different landmarks that agree. A pose is claimed only when enough landmarks in
/// enough images agree with it, when it is known well, and when no pose elsewhere has nearly as many: in rooms that
/// look alike several stay in the race until one wins.
class Relocaliser {
 public:
  Relocaliser(const RelocalisationOptions& options, std::uint64_t seed) : options_(options), seed_(seed) {}

  /// Forgets all images and hypotheses.
  void clear();
  /// Takes the features of the next image and the pose they and the ones before agree on, if they do.
  std::optional<Relocalisation> add(const LandmarkIndex& index, const Glimpse& glimpse, const cv::Mat& picture,
                                    std::span<const Eigen::Vector2d> features);
  /// The best pose of the last call, claimed or not; for a look.
  const std::optional<Relocalisation>& best() const { return best_; }

 private:
  struct Match {
    Sight sight;  // in base_link at its own image
    std::int64_t landmark;
  };
  struct Image {
    common::Nanoseconds stamp;
    common::Pose2 odometry;
    std::vector<Match> matches;
  };
  /// A match in base_link at the newest image.
  struct Evidence {
    Sight sight;
    std::int64_t landmark;
    int image;
  };
  struct Hypothesis {
    common::Pose2 pose;
    int landmarks = 0;
    double error = 0.0;  // sum over all, cut at the inlier's
  };

  std::vector<Match> match(const LandmarkIndex& index, const Glimpse& glimpse, const cv::Mat& picture,
                           std::span<const Eigen::Vector2d> features) const;
  std::vector<Evidence> gather() const;
  std::vector<Hypothesis> propose(const std::vector<Evidence>& evidence, common::Nanoseconds stamp) const;
  Hypothesis judge(const std::vector<Evidence>& evidence, const common::Pose2& pose) const;
  std::optional<RefinedPose> refine(const std::vector<Evidence>& evidence, const common::Pose2& pose) const;
  bool agrees(const Sight& sight, const common::Pose2& pose) const;

  RelocalisationOptions options_;
  std::uint64_t seed_;
  std::deque<Image> images_;
  std::vector<common::Pose2> race_;  // the best poses so far, T_map_base at the newest image
  double pixel_ = 0.002;             // angle of a pixel [rad]
  std::optional<Relocalisation> best_;
};

}  // namespace slamfuse::visual_slam
