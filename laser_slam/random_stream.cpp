// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/random_stream.hpp"

#include <cmath>
#include <numbers>

namespace slamfuse::laser_slam {
namespace {

/// The finaliser of SplitMix64: a bijection that scatters neighbouring inputs.
std::uint64_t scatter(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;  // SplitMix64's increment

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t stream)
    : state_(scatter(seed + kGolden) ^ scatter(stream * kGolden + 1)) {}

std::uint64_t RandomStream::next() {
  state_ += kGolden;
  return scatter(state_);
}

double RandomStream::uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

double RandomStream::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

Eigen::Vector3d RandomStream::normal3() {
  Eigen::Vector3d sample;
  for (double& value : sample) value = normal();
  return sample;
}

}  // namespace slamfuse::laser_slam
