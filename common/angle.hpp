// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <numbers>

namespace slamfuse::common {

/// An angle [rad] brought into (-pi, pi]. NaN and infinities give NaN.
inline double normalize_angle(double angle) {
  if (angle > -std::numbers::pi && angle <= std::numbers::pi) return angle;  // most are: the division is slow
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? std::numbers::pi : wrapped;
}

/// The signed shortest turn [rad] from `from` to `to`, in (-pi, pi].
inline double angle_difference(double to, double from) { return normalize_angle(to - from); }

constexpr double to_radians(double degrees) { return degrees * std::numbers::pi / 180.0; }
constexpr double to_degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

}  // namespace slamfuse::common
