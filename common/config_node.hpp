// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/error.hpp"

namespace slamfuse::common {

struct ConfigEntry;

/// A piece of a configuration as it was written, before anybody knows which options exist.
struct ConfigNode {
  enum class Kind { kNothing, kScalar, kList, kMap };

  Kind kind = Kind::kNothing;
  std::string where;                 ///< "file:line:column", or the assignment it comes from
  std::string text;                  ///< of a scalar
  bool was_quoted = false;           ///< a scalar in quotes is text, never a number
  std::vector<ConfigEntry> entries;  ///< of a map, in the order written, no key twice; a list's items are not kept
};

struct ConfigEntry {
  std::string key;
  std::string where;  ///< of the key
  ConfigNode value;
};

/// Reads a YAML file into a tree with a map at its root. Errors (kInvalidInput) as promised by read_options().
Result<ConfigNode> read_config_tree(const std::filesystem::path& yaml);

/// "laser.particles=50" as a tree of maps with one scalar. Errors (kUsage): no '=', an empty key.
Result<ConfigNode> parse_assignment(std::string_view assignment);

}  // namespace slamfuse::common
