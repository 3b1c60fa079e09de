// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/options.hpp"

namespace slamfuse::common {

/// What values an option may take, in words for error messages and documentation: "0.005 to 1.0 m", "at least 1".
std::string range_text(OptionVisitor::Range<double> range, const std::string& unit);
std::string range_text(OptionVisitor::Range<int> range, const std::string& unit);

/// A number as short as it reads back to the same double, with a decimal point or an exponent.
std::string real_text(double value);

}  // namespace slamfuse::common
