// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/keyframe.hpp"

namespace slamfuse::laser_slam {

StoredScan::StoredScan(const ScanBeams& scan) : match_points_(static_cast<int>(scan.match_points.size())) {
  beams_.reserve(scan.beams.size());
  hits_.reserve(scan.beams.size());
  for (const Beam& beam : scan.beams) {
    beams_.push_back({beam.origin.cast<float>(), beam.end.cast<float>()});
    hits_.push_back(beam.hit ? 1 : 0);
  }
}

ScanBeams StoredScan::restore() const {
  ScanBeams scan;
  scan.beams.reserve(beams_.size());
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    scan.beams.push_back({beams_[i].origin.cast<double>(), beams_[i].end.cast<double>(), hits_[i] != 0});
  }
  scan.match_points = thin_hits(scan.beams, match_points_);
  return scan;
}

}  // namespace slamfuse::laser_slam
