// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <string>

namespace slamfuse::service {

/// The process ends within `patience`, come what may: if it has not ended by itself until then, `last_words` go to
/// standard error and it ends with `exit_status`, without destructors. For the end of a program whose work is saved
/// and that may hang in what it tears down. Called again it does nothing.
void force_end(std::chrono::nanoseconds patience, const std::string& last_words, int exit_status);

}  // namespace slamfuse::service
