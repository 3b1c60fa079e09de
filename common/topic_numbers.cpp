// SPDX-License-Identifier: BSD-3-Clause
#include "common/topic_numbers.hpp"

#include <algorithm>
#include <utility>

namespace slamfuse::common {

std::size_t TopicNumbers::number_of(RosTopic topic) {
  if (const std::size_t at = topic.type.find("/msg/"); at != std::string::npos) topic.type.erase(at, 4);
  const auto found = std::find_if(topics_.begin(), topics_.end(), [&](const RosTopic& known) {
    return known.name == topic.name && known.type == topic.type;
  });
  if (found != topics_.end()) return static_cast<std::size_t>(found - topics_.begin());
  topics_.push_back(std::move(topic));
  return topics_.size() - 1;
}

}  // namespace slamfuse::common
