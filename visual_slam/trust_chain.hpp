// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <span>

#include "visual_slam/ekf.hpp"

namespace slamfuse::visual_slam {

/// Whether what is mapped after something went wrong (the wheels slipped) still hangs together with the map from
/// before.
///
/// Landmarks of before are trusted. An image that shows enough of them gives a pose that can be trusted, and so can the
/// other landmarks it shows. Once no image does, the chain is broken: new landmarks agree with each other whatever the
/// scale they were mapped with. It is whole again when the map of before is seen again.
class TrustChain {
 public:
  explicit TrustChain(int enough) : enough_(enough) {}

  /// Something went wrong: from now on only these landmarks are trusted.
  void begin(std::span<const LandmarkId> trusted) {
    if (!watching_) trusted_ = {trusted.begin(), trusted.end()};
    watching_ = true;
  }
  /// What went wrong is over and the pose is trusted: nothing needs watching.
  void end() {
    watching_ = false;
    trusted_.clear();
  }
  bool is_watching() const { return watching_; }
  /// Takes the landmarks of known place that an image shows; returns whether its pose is trusted.
  bool see(std::span<const LandmarkId> landmarks);

 private:
  int enough_;
  bool watching_ = false;
  std::set<LandmarkId> trusted_;
};

}  // namespace slamfuse::visual_slam
