// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "visual_slam/options.hpp"

namespace cv {
class Mat;
}

namespace slamfuse::visual_slam {

/// A feature to be found again in the next picture of its camera.
struct ExpectedFeature {
  std::int64_t id = 0;
  Eigen::Vector2d last = Eigen::Vector2d::Zero();       ///< pixel in the camera's previous picture
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  ///< pixel where it should be now
};

/// A feature found.
struct FoundFeature {
  std::int64_t id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

/// Finds features in pictures and follows them: the only part besides LandmarkRecogniser that looks at pixels.
///
/// All work on pixels of a picture is behind this interface and behind FeatureExtractor: that is where a front end on a
/// graphics card would go, as another FrontEndKind. Deterministic, and independent of how many threads OpenCV uses.
/// Pictures are 8-bit gray; those of one camera have one size and come in the order of time.
class FrontEnd {
 public:
  virtual ~FrontEnd() = default;

  /// Takes the next picture of a camera and finds in it features of the previous one; those not found are left out.
  virtual std::vector<FoundFeature> follow(std::size_t camera, const cv::Mat& picture,
                                           std::span<const ExpectedFeature> expected) = 0;

  /// New features in the picture that `follow` took last for this camera: at most `wanted`, spread over the picture,
  /// away from the pixels `taken` and where `region` is not 0 (an empty region is the whole picture; seed 001's
  /// selected regions go in here).
  virtual std::vector<Eigen::Vector2d> detect(std::size_t camera, std::span<const Eigen::Vector2d> taken, int wanted,
                                              const cv::Mat& region) = 0;
};

/// The front end the options name, for so many cameras: Shi-Tomasi with Lucas-Kanade, SIFT or ORB.
std::unique_ptr<FrontEnd> make_front_end(const FrontEndOptions& options, std::size_t cameras);

}  // namespace slamfuse::visual_slam
