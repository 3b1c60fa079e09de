// SPDX-License-Identifier: BSD-3-Clause
#include "service/report_charts.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>

#include "common/angle.hpp"
#include "service/map_picture.hpp"
#include "service/state_history.hpp"

namespace slamfuse::service {
namespace {

using common::PoseEstimate;
using common::TrackingState;

constexpr std::size_t kMaxBands = 1000;

// The heights tell the states apart without colour.
Band band_of(double from, double to, TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return {from, to, "tracking", 0.45};
    case TrackingState::kUncertain:
      return {from, to, "uncertain", 0.7};
    case TrackingState::kLost:
      break;
  }
  return {from, to, "lost", 1.0};
}

// Of so many that they could not be told apart: each part of the time in its worst state.
std::vector<Band> worst_of_equal_parts(const std::vector<Band>& bands, double duration_s) {
  std::vector<Band> coarse;
  std::size_t first = 0;
  for (std::size_t k = 0; k < kMaxBands; ++k) {
    const double from = duration_s * static_cast<double>(k) / kMaxBands;
    const double to = duration_s * static_cast<double>(k + 1) / kMaxBands;
    while (first + 1 < bands.size() && bands[first].to <= from) ++first;
    Band worst = bands[first];
    for (std::size_t i = first; i < bands.size() && bands[i].from < to; ++i) {
      if (bands[i].height > worst.height) worst = bands[i];
    }
    if (!coarse.empty() && coarse.back().style == worst.style) {
      coarse.back().to = to;
    } else {
      coarse.push_back({from, to, worst.style, worst.height});
    }
  }
  return coarse;
}

double seconds_since(common::Nanoseconds start, common::Nanoseconds stamp) { return common::to_seconds(stamp - start); }

ChartFrame over_time(const ReportData& data, const std::string& title, const std::string& y_label) {
  return {.title = title, .x_label = "time [s]", .y_label = y_label, .x_min = 0.0, .x_max = data.duration_s};
}

// One series of every source (the odometry only when asked for), by a function of one of its lists of records.
template <class Record>
std::vector<ChartSeries> series_of_sources(const ReportData& data, std::vector<Record> ReportSource::*records,
                                           const std::function<double(const Record&)>& value, bool dots,
                                           bool with_odometry) {
  std::vector<ChartSeries> all;
  for (const ReportSource& source : data.sources) {
    if (source.source == common::PoseSource::kOdometry && !with_odometry) continue;
    const std::string name = common::to_string(source.source);
    ChartSeries series{name, name, {}, dots};
    for (const Record& record : source.*records) {
      series.points.emplace_back(seconds_since(data.start, record.stamp), value(record));
    }
    if (!series.points.empty()) all.push_back(std::move(series));
  }
  return all;
}

using HealthFigure = std::function<std::optional<double>(const common::Health&)>;

std::vector<ChartSeries> health_series(const ReportData& data, const std::string& suffix, const HealthFigure& figure) {
  std::vector<ChartSeries> all;
  for (const ReportSource& source : data.sources) {
    if (source.source == common::PoseSource::kFused) continue;  // it only repeats a half's figures
    const std::string name = common::to_string(source.source);
    ChartSeries series{suffix.empty() ? name : name + " " + suffix, name, {}};
    for (const PoseEstimate& estimate : source.estimates) {
      series.points.emplace_back(seconds_since(data.start, estimate.stamp),
                                 figure(estimate.health).value_or(std::nan("")));
    }
    const bool measured =
        std::any_of(series.points.begin(), series.points.end(), [](const auto& p) { return std::isfinite(p.y()); });
    if (measured) all.push_back(std::move(series));
  }
  return all;
}

template <class T>
std::optional<double> as_real(const std::optional<T>& value) {
  return value ? std::optional<double>(static_cast<double>(*value)) : std::nullopt;
}

void add_chart(std::vector<std::string>& charts, std::string chart) {
  if (!chart.empty()) charts.push_back(std::move(chart));
}

}  // namespace

std::vector<Band> state_bands(const ReportSource& source, common::Nanoseconds start, double duration_s) {
  std::vector<Band> bands;
  for (const auto& stretch : without_holes(source.states, start, start + common::from_seconds(duration_s))) {
    bands.push_back(band_of(seconds_since(start, stretch.from), seconds_since(start, stretch.to), stretch.state));
  }
  return bands.size() > kMaxBands ? worst_of_equal_parts(bands, duration_s) : bands;
}

std::string plan_picture(const ReportData& data) {
  MapPicture picture;
  if (data.grid) picture.grid = &*data.grid;
  if (!data.truth.empty()) picture.paths.push_back({"truth", "truth", data.truth});
  for (const ReportSource& source : data.sources) {
    const std::string name = common::to_string(source.source);
    if (!source.path.empty()) picture.paths.push_back({name, name, source.path});
  }
  picture.landmarks = data.landmarks;
  return map_picture(picture);
}

std::vector<std::string> error_charts(const ReportData& data) {
  const std::function<double(const ReportError&)> metres = [](const ReportError& e) { return e.position; };
  const std::function<double(const ReportError&)> degrees = [](const ReportError& e) {
    return common::to_degrees(e.heading);
  };
  std::vector<std::string> charts;
  const auto add = [&](const std::string& title, const std::string& y_label, const auto& value, bool with_odometry) {
    add_chart(charts, line_chart(over_time(data, title, y_label),
                                 series_of_sources(data, &ReportSource::errors, value, false, with_odometry)));
  };
  add("Position error", "error [m]", metres, false);
  add("Heading error", "error [deg]", degrees, false);
  add("Position error, with wheel odometry alone", "error [m]", metres, true);
  add("Heading error, with wheel odometry alone", "error [deg]", degrees, true);
  return charts;
}

std::vector<std::string> state_charts(const ReportData& data) {
  std::vector<BandRow> rows;
  for (const ReportSource& source : data.sources) {
    if (source.states.empty()) continue;
    rows.push_back({common::to_string(source.source), state_bands(source, data.start, data.duration_s)});
  }
  std::vector<std::string> charts;
  add_chart(charts, band_chart(over_time(data, "State", ""), rows,
                               {{"TRACKING", "tracking"}, {"UNCERTAIN", "uncertain"}, {"LOST or silent", "lost"}}));
  return charts;
}

std::vector<std::string> health_charts(const ReportData& data) {
  std::vector<std::string> charts;
  const auto add = [&](const std::string& title, const std::string& y_label, std::vector<ChartSeries> series) {
    add_chart(charts, line_chart(over_time(data, title, y_label), series));
  };
  add("Agreement of the scan with the map", "likelihood (0..1)",
      health_series(data, "", [](const auto& health) { return health.scan_likelihood; }));
  add("Effective particles", "particles",
      health_series(data, "", [](const auto& health) { return health.effective_particles; }));
  auto features = health_series(data, "matched", [](const auto& health) { return as_real(health.tracked_features); });
  for (auto& series : features) series.style = "other";
  for (auto& series : health_series(data, "accepted", [](const auto& health) { return as_real(health.inliers); })) {
    features.push_back(series);
  }
  add("Features", "features", std::move(features));
  add("Innovation (1 when the filter's covariances are right)", "NIS per freedom",
      health_series(data, "", [](const auto& health) { return health.innovation; }));
  return charts;
}

std::vector<std::string> update_charts(const ReportData& data) {
  std::vector<std::string> charts;
  add_chart(charts, line_chart(over_time(data, "Computing time of each update", "time [ms]"),
                               series_of_sources<ReportUpdate>(
                                   data, &ReportSource::updates, [](const ReportUpdate& u) { return u.milliseconds; },
                                   true, true)));
  return charts;
}

}  // namespace slamfuse::service
