// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "service/dds_publisher.hpp"
#include "service/run_summary.hpp"

namespace slamfuse::service {

/// Whether a module made a pose: without one there is no result.
bool has_pose(const RunSummary& summary);

/// The outcome of a run for a terminal; `folder` holds its results.
std::string in_words(const RunSummary& summary, const std::filesystem::path& folder);

/// What a listener on DDS gets at the end: all in the laser map's frame. Refers to the summary's grid.
DdsFinalState final_state_of(const RunSummary& summary);

/// Adds an event where messages could not be sent.
void tell_failures(const DdsPublisher& publisher, RunSummary& summary);

}  // namespace slamfuse::service
