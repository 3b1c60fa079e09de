// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/time.hpp"
#include "service/report.hpp"
#include "service/state_history.hpp"

namespace slamfuse::service {
namespace {

const ReportAccuracy* accuracy_of(const ReportData& data, const std::string& name) {
  const auto found =
      std::find_if(data.accuracy.begin(), data.accuracy.end(), [&](const auto& row) { return row.name == name; });
  return found == data.accuracy.end() ? nullptr : &*found;
}

double lost_seconds(const ReportSource& source, const ReportData& data) {
  double seconds = 0.0;
  for (const auto& stretch :
       without_holes(source.states, data.start, data.start + common::from_seconds(data.duration_s))) {
    if (stretch.state == common::TrackingState::kLost) seconds += common::to_seconds(stretch.to - stretch.from);
  }
  return seconds;
}

// "a", "a and b", "a, b and c".
std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  }
  return text;
}

std::string availability(const ReportData& data) {
  std::vector<std::string> parts;
  std::vector<std::string> always;
  for (const ReportSource& source : data.sources) {
    if (source.source == common::PoseSource::kOdometry || source.states.empty()) continue;
    const double lost = lost_seconds(source, data);
    const std::string name = common::to_string(source.source);
    if (lost > 0.0) {
      parts.push_back(fmt::format("{} had no pose for {:.1f} s", name, lost));
    } else {
      always.push_back(name);
    }
  }
  if (!always.empty()) parts.insert(parts.begin(), list(always) + " always had a pose");
  return parts.empty() ? "No estimator gave a pose." : fmt::format("Of {:.1f} s, {}.", data.duration_s, list(parts));
}

std::string accuracy(const ReportData& data) {
  const ReportAccuracy* fused = accuracy_of(data, "fused");
  if (fused == nullptr) return "";
  std::string text = fmt::format(" The fused pose was {:.3f} m from the truth (rms)", fused->ate_rmse);
  if (const ReportAccuracy* odometry = accuracy_of(data, "odometry")) {
    text += fmt::format("; wheel odometry alone was {:.3f} m off", odometry->ate_rmse);
  }
  return text + ".";
}

std::string agreement(const ReportData& data) {
  if (!data.alignment) return " The laser and the visual path were not aligned with each other.";
  const ReportAlignment& alignment = *data.alignment;
  if (!alignment.accepted) {
    return " The alignment of the visual with the laser path was refused: " + alignment.reason + ".";
  }
  return fmt::format(" The visual path agrees with the laser path to {:.3f} m (rms of {} pairs).", alignment.rmse,
                     alignment.pairs);
}

}  // namespace

std::string verdict_in_words(const ReportData& data) {
  const std::string interrupted = data.complete ? "" : "The run was interrupted: what follows is incomplete. ";
  return interrupted + availability(data) + accuracy(data) + agreement(data);
}

}  // namespace slamfuse::service
