// SPDX-License-Identifier: BSD-3-Clause
#include "service/report_tables.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "common/angle.hpp"
#include "service/markup.hpp"

namespace slamfuse::service {
namespace {

using Row = std::vector<std::string>;  // cells as plain text

std::string cells(const Row& row, const std::string& tag) {
  std::string html = "<tr>";
  for (const std::string& cell : row) html += "<" + tag + ">" + escape(cell) + "</" + tag + ">";
  return html + "</tr>\n";
}

// `style` is the CSS class: "figures" right-aligns all columns but the first, "words" aligns all to the left.
std::string table(const std::string& style, const Row& head, const std::vector<Row>& rows) {
  std::string html =
      "<div class=\"scroll\"><table class=\"" + style + "\"><thead>" + cells(head, "th") + "</thead><tbody>\n";
  for (const Row& row : rows) html += cells(row, "td");
  return html + "</tbody></table></div>\n";
}

std::string sentence(const std::string& text) { return "<p class=\"soft\">" + escape(text) + "</p>\n"; }

std::string percent(double fraction) { return number(100.0 * fraction, 1); }

std::string events_left_out(const std::vector<common::Event>& events) {
  std::map<std::string, std::size_t> kinds;
  for (std::size_t i = kMaxListedEvents; i < events.size(); ++i) ++kinds[events[i].module + " " + events[i].kind];
  std::string list;
  for (const auto& [kind, count] : kinds) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", count, kind);
  return fmt::format("and {} more: {}", events.size() - kMaxListedEvents, list);
}

}  // namespace

std::string accuracy_table(const ReportData& data) {
  if (data.accuracy.empty()) return sentence("No ground truth lies beside the recording, so errors cannot be told.");
  std::vector<Row> rows;
  for (const ReportAccuracy& row : data.accuracy) {
    rows.push_back({row.name, row.align, number(row.ate_rmse, 3), number(row.ate_max, 3),
                    number(common::to_degrees(row.heading_rmse), 2),
                    row.rpe_percent ? number(*row.rpe_percent, 2) : "-", percent(row.coverage)});
  }
  return table("figures",
               {"path", "fitted by", "error rms [m]", "largest [m]", "heading rms [deg]", "drift [%]", "coverage [%]"},
               rows) +
         sentence(
             "Error: distance from the truth after the best fit of the whole path (se2: turn and shift, sim2: scale "
             "too). Drift: relative pose error, \"-\" on a path too short for it. Coverage: share of the time with a "
             "pose that was not LOST. Paths "
             "named final are as known at the end of the run, the others as known at each moment.");
}

std::string module_table(const ReportData& data) {
  if (data.modules.empty()) return sentence("No module ran.");
  std::vector<Row> rows;
  for (const ReportModule& row : data.modules) {
    rows.push_back({row.name, std::to_string(row.inputs), std::to_string(row.poses), std::to_string(row.dropped),
                    std::to_string(row.rejected), percent(row.coverage), number(row.update_median_ms, 1),
                    number(row.update_p95_ms, 1), number(row.update_p99_ms, 1), number(row.update_max_ms, 1)});
  }
  return table("figures",
               {"module", "inputs", "poses", "dropped", "rejected", "coverage [%]", "median [ms]", "95 % [ms]",
                "99 % [ms]", "longest [ms]"},
               rows);
}

std::string alignment_table(const ReportData& data) {
  if (!data.alignment) return sentence("The two paths were not aligned: it takes a laser and a visual path.");
  const ReportAlignment& a = *data.alignment;
  const std::string verdict = fmt::format("<p><strong>{}</strong> by method {}: {}</p>\n",
                                          a.accepted ? "Accepted" : "Refused", escape(a.method), escape(a.reason));
  return verdict +
         table("words", {"figure", "value", "what it means"},
               {{"scale", number(a.scale.x(), 4) + " / " + number(a.scale.y(), 4),
                 "laser metres for one unit of the visual map, along x / y; 1 when both are metric, equal unless the "
                 "visual map is stretched"},
                {"rotation", number(common::to_degrees(a.rotation), 2) + " deg", "from the visual to the laser map"},
                {"residual", number(a.rmse, 4) + " m", "rms distance between paired poses after the alignment"},
                {"held-out residual", number(a.heldout_rmse, 4) + " m",
                 "the same on pairs the fit did not see; close to the residual when the fit generalises"},
                {"pairs", std::to_string(a.pairs), "poses of both paths at the same time"},
                {"runner-up ratio", number(a.runner_up_ratio, 2),
                 "loss at the second best angle over that at the best; near 1 the path is too straight or symmetric "
                 "to tell"}});
}

std::string event_table(const ReportData& data) {
  if (data.events.empty()) return sentence("Nothing happened that is worth telling.");
  std::vector<common::Event> events = data.events;
  std::stable_sort(events.begin(), events.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  std::vector<Row> rows;
  for (std::size_t i = 0; i < std::min(events.size(), kMaxListedEvents); ++i) {
    rows.push_back({number(common::to_seconds(events[i].stamp - data.start), 2), events[i].module, events[i].kind,
                    events[i].detail});
  }
  std::string html = table("words", {"time [s]", "module", "what", "detail"}, rows);
  if (events.size() > kMaxListedEvents) html += sentence(events_left_out(events));
  return html;
}

}  // namespace slamfuse::service
