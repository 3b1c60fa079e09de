// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace slamfuse::service {

/// Text made safe inside HTML and XML, in elements and in quoted attributes: the five special characters become
/// entities; what no XML document may hold (control characters, bytes that are not UTF-8) becomes U+FFFD.
std::string escape(std::string_view text);

/// A number with that many decimals; an en dash when it is not finite.
std::string number(double value, int decimals);

}  // namespace slamfuse::service
