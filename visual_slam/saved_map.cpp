// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/saved_map.hpp"

#include <cstdint>
#include <set>

#include <fmt/format.h>

namespace slamfuse::visual_slam {

common::Result<void> check_saved_map(const std::vector<common::Landmark>& map) {
  std::set<std::int64_t> numbers;
  bool recognisable = false;
  for (const common::Landmark& landmark : map) {
    if (!landmark.position.allFinite() || !landmark.covariance.allFinite()) {
      return common::invalid_input(fmt::format("visual map: landmark {} has a place that is no number", landmark.id));
    }
    if (!numbers.insert(landmark.id).second) {
      return common::invalid_input(fmt::format("visual map: two landmarks have the number {}", landmark.id));
    }
    if (!landmark.views.empty()) recognisable = true;
  }
  if (!recognisable) {
    return common::invalid_input(
        fmt::format("visual map: none of its {} landmarks has a view it could be recognised by; map anew", map.size()));
  }
  return {};
}

}  // namespace slamfuse::visual_slam
