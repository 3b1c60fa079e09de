// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace slamfuse::common {

/// A point in time or a duration in integer nanoseconds. Points are the sensor's own stamps (usually Unix time), never
/// the clock at arrival.
using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds kNanosecondsPerSecond = 1'000'000'000;

/// The year 2096. Later stamps are garbled, and differences of two stamps up to here fit in Nanoseconds.
inline constexpr Nanoseconds kLatestStamp = 4'000'000'000 * kNanosecondsPerSecond;

/// Nanoseconds as floating-point seconds: for durations only, a Unix stamp loses its last digits in a double.
constexpr double to_seconds(Nanoseconds duration) { return static_cast<double>(duration) * 1e-9; }

/// Seconds as nanoseconds, rounded to nearest; for durations and settings, not for stamps.
Nanoseconds from_seconds(double seconds);

/// Parses decimal seconds such as "976052857.337284" digit by digit, never through a double. An optional sign, digits,
/// and up to nine decimals count (further decimals are cut). Exponents are read too ("1.5e9"). Returns nothing when the
/// text is not a finite decimal number between -kLatestStamp and kLatestStamp.
std::optional<Nanoseconds> parse_decimal_seconds(std::string_view text);

/// Seconds with exactly nine decimals, e.g. "976052857.337284000".
std::string format_seconds(Nanoseconds time);

}  // namespace slamfuse::common
