// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slamfuse::service {

/// The frames of a robot as REP 105 names them.
inline const std::string kMapFrame = "map";
inline const std::string kOdomFrame = "odom";
inline const std::string kBaseFrame = "base_link";

}  // namespace slamfuse::service
