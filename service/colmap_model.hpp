// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/calibration.hpp"
#include "common/keyframe.hpp"
#include "common/landmark.hpp"

namespace slamfuse::service {

/// A sparse model in COLMAP's text format (https://colmap.github.io/format.html): what other structure-from-motion
/// programs read, and what seed 002 section 3.1 hands to its viewer.
struct ColmapModel {
  std::string cameras;  ///< cameras.txt
  std::string images;   ///< images.txt
  std::string points;   ///< points3D.txt
};

/// The visual map as such a model, in the visual map's frame (a comment line says so): the cameras that have keyframes,
/// numbered by name; the keyframes as images, numbered from 1 as given, named `CAMERA/STAMP_NS.jpg`; the landmarks as
/// points with their own numbers.
///
/// - Lens: PINHOLE without distortion, OPENCV with k1 k2 p1 p2, FULL_OPENCV when there is a k3.
/// - COLMAP has pixel centres at halves, we at whole numbers: 0.5 is added to principal points and observations.
/// - Observations are as measured. A rolling shutter is not part of the format: their rows were exposed up to half the
///   readout before or after the pose.
/// - ERROR of a point is the mean distance [px] of its observations from where the model puts them, -1 without any.
///   Observations of landmarks that have left the map are left out.
ColmapModel colmap_model(const std::map<std::string, common::CameraCalibration>& cameras,
                         const std::vector<common::Keyframe>& keyframes,
                         const std::vector<common::Landmark>& landmarks);

}  // namespace slamfuse::service
