// SPDX-License-Identifier: BSD-3-Clause
#include "service/metrics.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "common/angle.hpp"
#include "service/update_times.hpp"

namespace slamfuse::service {
namespace {

using Json = nlohmann::ordered_json;

/// JSON knows no NaN and no infinity.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string module_name(common::PoseSource source) {
  return source == common::PoseSource::kFused ? "fusion" : common::to_string(source);
}

Json module_metrics(const ModuleCounters& counters, double coverage) {
  std::vector<double> milliseconds;
  for (const auto& update : counters.updates.items()) milliseconds.push_back(update.milliseconds);
  const UpdateTimes times = summarise_update_times(std::move(milliseconds));
  return {
      {"inputs", counters.inputs},
      {"poses", counters.poses},
      {"dropped", counters.dropped},
      {"rejected", counters.rejected},
      {"coverage", number(coverage)},
      {"update_ms", {{"median", times.median}, {"p95", times.p95}, {"p99", times.p99}, {"max", counters.slowest_ms}}}};
}

Json events_metrics(const std::vector<common::Event>& events) {
  Json list = Json::array();
  for (const auto& event : events) {
    list.push_back(
        {{"stamp_ns", event.stamp}, {"module", event.module}, {"kind", event.kind}, {"detail", event.detail}});
  }
  return list;
}

Json offsets_metrics(const fusion::Alignment& alignment) {
  const fusion::SensorOffsets& found = *alignment.offsets;
  return {{"clock_offset_s", number(found.clock_offset)},
          {"clock_sigma_s", number(found.clock_sigma)},
          {"clock_used_s", number(alignment.clock_offset)},
          {"lever_arm_m", {number(found.lever_arm.x()), number(found.lever_arm.y())}},
          {"lever_sigma_m", {number(found.lever_sigma.x()), number(found.lever_sigma.y())}},
          {"lever_used_m", {number(alignment.lever_arm.x()), number(alignment.lever_arm.y())}},
          {"yaw_deg", number(common::to_degrees(found.yaw))},
          {"yaw_sigma_deg", number(common::to_degrees(found.yaw_sigma))}};
}

}  // namespace

const char* program_version() { return SLAMFUSE_VERSION; }

std::string json_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json alignment_metrics(const fusion::Alignment& alignment) {
  Json metrics = {{"verdict", alignment.accepted ? "accepted" : "refused"},
                  {"reason", alignment.reason},
                  {"method", to_string(alignment.method)},
                  {"scale", {number(alignment.scale.x()), number(alignment.scale.y())}},
                  {"scale_sigma", number(alignment.scale_sigma)},
                  {"rotation_deg", number(alignment.rotation_deg)},
                  {"rmse_m", number(alignment.rmse)},
                  {"heldout_rmse_m", number(alignment.heldout_rmse)},
                  {"forward_rmse_m", number(alignment.forward_rmse)},
                  {"pairs", alignment.pairs},
                  {"runner_up_ratio", number(alignment.runner_up_ratio)}};
  if (alignment.offsets) metrics["sensor_offsets"] = offsets_metrics(alignment);
  return metrics;
}

Json accuracy_metrics(const common::TrajectoryAccuracy& accuracy) {
  return {{"align", to_string(accuracy.align)},
          {"ate_rmse_m", number(accuracy.ate_rmse_m)},
          {"ate_max_m", number(accuracy.ate_max_m)},
          {"heading_rmse_deg", number(accuracy.heading_rmse_deg)},
          {"rpe_percent", accuracy.rpe_percent ? number(*accuracy.rpe_percent) : Json(nullptr)},
          {"coverage", number(accuracy.coverage)}};
}

Json metrics_of(const RunSummary& summary) {
  Json metrics{{"slamfuse", program_version()},
               {"seed", summary.seed},
               {"recording", summary.recording},
               {"incomplete", summary.incomplete},
               {"duration_s", summary.duration_s},
               {"wall_s", summary.wall_s},
               {"real_time_factor", number(summary.duration_s / summary.wall_s)},
               {"peak_rss_mb", summary.peak_rss_mb},
               {"modules", Json::object()},
               {"accuracy", Json::object()}};
  for (const auto& [source, counters] : summary.counters) {
    const auto coverage = summary.coverage.find(source);
    metrics["modules"][module_name(source)] =
        module_metrics(counters, coverage == summary.coverage.end() ? 0.0 : coverage->second);
  }
  for (const auto& row : summary.accuracy) metrics["accuracy"][row.name] = accuracy_metrics(row.accuracy);
  if (summary.alignment) metrics["alignment"] = alignment_metrics(*summary.alignment);
  metrics["events"] = events_metrics(summary.log.events);
  return metrics;
}

}  // namespace slamfuse::service
