// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace slamfuse::laser_slam {

/// A seeded stream of random numbers that is the same on every run, compiler and thread: SplitMix64 (Steele, Lea, Flood
/// 2014) with Box-Muller, because the standard library's distributions are not specified bit by bit. Each particle owns
/// one, so the number of threads cannot matter.
class RandomStream {
 public:
  /// Streams of one seed with different `stream` numbers are independent.
  RandomStream(std::uint64_t seed, std::uint64_t stream);

  std::uint64_t next();
  /// Evenly in [0, 1).
  double uniform();
  /// Standard normal.
  double normal();
  /// Three independent standard normals.
  Eigen::Vector3d normal3();

 private:
  std::uint64_t state_;
};

}  // namespace slamfuse::laser_slam
