// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "common/recording.hpp"

namespace slamfuse::system {

/// What two recordings have in common.
struct Comparison {
  std::map<std::string, std::size_t> same;  ///< messages that are identical, by sensor
  std::string difference;                   ///< the first one, in words; empty: none
};

/// Compares two recordings message by message, each sensor for itself: stamps and every number and pixel. Messages that
/// a reader rejects take no part.
Comparison compare(common::Recording& expected, common::Recording& actual);

}  // namespace slamfuse::system
