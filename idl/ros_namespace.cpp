// SPDX-License-Identifier: BSD-3-Clause
#include "idl/ros_namespace.hpp"

#include <regex>

namespace slamfuse::idl {

common::Result<RosNamespace> RosNamespace::create(const std::string& text) {
  if (text.empty() || text == "/") return RosNamespace();
  // DDS topic names have 256 characters at most; a regular expression would take long texts badly.
  constexpr std::size_t kLongest = 128;
  static const std::regex kForm("/?([A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*)");
  std::smatch parts;
  if (text.size() <= kLongest && std::regex_match(text, parts, kForm)) return RosNamespace(parts[1].str());
  return common::invalid_input("'" + text +
                               "' is no ROS namespace (allowed: words of letters, digits and underscores that begin "
                               "with no digit, joined by slashes, 128 characters)");
}

std::string RosNamespace::resolve(const std::string& name) const {
  if (name.starts_with('/')) return name.substr(1);
  return words_.empty() ? name : words_ + "/" + name;
}

}  // namespace slamfuse::idl
