// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "service/chart.hpp"
#include "service/report.hpp"

namespace slamfuse::service {

/// When a source was in which state, in seconds since the start of the run, a silence of more than 0.5 s being LOST
/// (see without_holes()). Where there would be more than 1000 bands, the worst state of each of 1000 equal stretches.
std::vector<Band> state_bands(const ReportSource& source, common::Nanoseconds start, double duration_s);

/// The plan with the grid, the paths and the landmarks; empty text when there is nothing to draw.
std::string plan_picture(const ReportData& data);

/// The charts over time as <svg> elements, those without data left out: errors, states, health, update times.
std::vector<std::string> error_charts(const ReportData& data);
std::vector<std::string> state_charts(const ReportData& data);
std::vector<std::string> health_charts(const ReportData& data);
std::vector<std::string> update_charts(const ReportData& data);

}  // namespace slamfuse::service
