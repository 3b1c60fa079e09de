// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slamfuse::idl {

/// Takes Cyclone's log away from stderr, for the whole process and from the first call on: nothing below main prints,
/// and a flood of corrupted packets must not become a flood of lines. The newest lines are kept.
void capture_cyclone_log();

/// What Cyclone logged since the last call, joined by "; ": at most its newest five lines. For error messages.
std::string take_cyclone_log();

}  // namespace slamfuse::idl
