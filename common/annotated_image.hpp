// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::common {

/// What became of a feature in an image.
enum class FeatureOutcome {
  kNew,         ///< entered into the map by this image
  kFollowed,    ///< of the camera's previous image, accepted
  kRecognised,  ///< a landmark out of sight before, found again by its looks, accepted
  kRejected,    ///< found, but it does not fit the map
};

/// A feature in an image.
struct FeatureMark {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< [px], pixel centres at whole numbers
  FeatureOutcome kind = FeatureOutcome::kNew;
};

/// An image with the features found in it, to be looked at by people. Shares the image's pixels.
struct AnnotatedImage {
  Image image;
  TrackingState state = TrackingState::kTracking;  ///< after the image
  std::vector<FeatureMark> features;
};

}  // namespace slamfuse::common
