// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace slamfuse::common {

/// Text from a file or a command line, fit to stand in an error message: in double quotes, cut after 60 characters,
/// bytes that do not print replaced by '?'. A binary file given by mistake then still leads to a readable message.
std::string quote(std::string_view text);

}  // namespace slamfuse::common
