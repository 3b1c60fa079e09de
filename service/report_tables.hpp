// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "service/report.hpp"

namespace slamfuse::service {

/// At most so many events are listed; the rest is counted by kind.
inline constexpr std::size_t kMaxListedEvents = 200;

/// The tables of the report as HTML; a sentence instead where there is nothing to tell.
std::string accuracy_table(const ReportData& data);
std::string module_table(const ReportData& data);
std::string alignment_table(const ReportData& data);
std::string event_table(const ReportData& data);

}  // namespace slamfuse::service
