// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

namespace slamfuse::common {

/// The upper of the two middle values where their number is even. There must be one.
double median(std::vector<double> values);

}  // namespace slamfuse::common
