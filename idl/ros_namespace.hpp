// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/error.hpp"

namespace slamfuse::idl {

/// The namespace that ROS 2 puts a node's relative names in.
class RosNamespace {
 public:
  /// The root, "/".
  RosNamespace() = default;
  /// Of "", "/", "robot" or "/robot/front": words of letters, digits and underscores that begin with no digit, joined
  /// by single slashes; of what ROS allows that is all but "~" and "{}". Error (kInvalidInput): anything else.
  static common::Result<RosNamespace> create(const std::string& text);

  /// The full name of a topic, service or node, without the leading slash as readers and writers take it: "pose" in
  /// "/robot" is "robot/pose". A name with a leading slash is absolute: "/tf" is "tf" in every namespace.
  std::string resolve(const std::string& name) const;
  /// With leading slash, as in ROS 2's graph: "/" or "/robot/front".
  std::string name() const { return "/" + words_; }

 private:
  explicit RosNamespace(std::string words) : words_(std::move(words)) {}
  std::string words_;  // without slashes at the ends
};

}  // namespace slamfuse::idl
