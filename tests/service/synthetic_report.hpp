// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "service/report.hpp"

namespace slamfuse::service {

/// The data of a made-up run through a room with every part filled in: `poses` estimates of each half, 0.1 s apart.
ReportData synthetic_report(std::size_t poses);

}  // namespace slamfuse::service
