// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "service/report.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// What the report page of a run shows: everything brought into the frame of the laser map. The visual path comes over
/// by the alignment (when accepted), the odometry is put on the first laser pose, the truth on the laser's path.
ReportData report_of(const RunSummary& summary);

}  // namespace slamfuse::service
