// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "fusion/alignment.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// metrics.json of a run, as DESIGN section 5 fixes it. Keys stand in a fixed order; numbers that could not be measured
/// are null.
nlohmann::ordered_json metrics_of(const RunSummary& summary);

/// Its part "alignment", all that metrics.json of `slamfuse align` has beside version and seed.
nlohmann::ordered_json alignment_metrics(const fusion::Alignment& alignment);

/// One row of its part "accuracy", also what `slamfuse evaluate --json` prints.
nlohmann::ordered_json accuracy_metrics(const common::TrajectoryAccuracy& accuracy);

/// JSON as it is written to a file: indented, bytes that are not UTF-8 (odd file names) replaced, a newline at the end.
std::string json_text(const nlohmann::ordered_json& json);

/// The program's version, as `slamfuse --version` prints it.
const char* program_version();

}  // namespace slamfuse::service
