// SPDX-License-Identifier: BSD-3-Clause
#include "service/report.hpp"

#include <fmt/format.h>

#include "service/chart.hpp"
#include "service/feature_overlay.hpp"
#include "service/markup.hpp"
#include "service/report_charts.hpp"
#include "service/report_tables.hpp"

namespace slamfuse::service {
namespace {

constexpr const char* kPageStyle = R"css(:root{color-scheme:light dark}
*{box-sizing:border-box}
body{margin:0 auto;padding:1rem;max-width:72rem;background:var(--ground);color:var(--ink);
font:16px/1.45 system-ui,sans-serif;overflow-wrap:break-word}
h1{font-size:1.5rem;margin:.2rem 0 .6rem}h2{font-size:1.15rem;margin:1.8rem 0 .5rem}
p{margin:.4rem 0}.soft,dt{color:var(--soft);font-size:.875rem}
.verdict{font-size:1.1rem;border-left:.3rem solid var(--fused);padding:.3rem .8rem;margin:.8rem 0}
.incomplete{border-color:var(--lost)}
dl{display:grid;grid-template-columns:repeat(auto-fit,minmax(9rem,1fr));gap:.4rem 1rem;margin:.8rem 0}
dl div{min-width:0}dd{margin:0;font-variant-numeric:tabular-nums}
figure{margin:.5rem 0}figure>svg{display:block;width:100%;height:auto}
.plan-figure>svg{max-height:90vh;max-width:48rem}
.charts{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,26rem),1fr));gap:.5rem 1.2rem}
.images{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,20rem),1fr));gap:.5rem 1rem}
.legend>svg{max-width:34rem}
.scroll{overflow-x:auto}
table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums;margin:.4rem 0}
th,td{padding:.25rem .7rem .25rem 0;text-align:left;vertical-align:top;border-bottom:1px solid var(--rule)}
th{font-weight:600;color:var(--soft)}
.figures th:not(:first-child),.figures td:not(:first-child){text-align:right}
.words td:last-child{min-width:11rem}.words th,.words td:first-child{white-space:nowrap}
)css";

std::string fact(const std::string& name, const std::string& value) {
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", escape(name), escape(value));
}

std::string header(const ReportData& data) {
  return fmt::format("<h1>slamfuse run</h1>\n<p class=\"verdict{}\">{}</p>\n<dl>", data.complete ? "" : " incomplete",
                     escape(verdict_in_words(data))) +
         fact("recording", data.recording) + fact("length", number(data.duration_s, 1) + " s") +
         fact("computed in", number(data.wall_s, 1) + " s") +
         fact("real-time factor", number(data.real_time_factor, 1)) +
         fact("peak memory", number(data.peak_rss_mb, 0) + " MB") + fact("seed", std::to_string(data.seed)) +
         fact("slamfuse", data.version) + "</dl>\n";
}

std::string section(const std::string& title, const std::string& content) {
  return "<section><h2>" + escape(title) + "</h2>\n" + content + "</section>\n";
}

std::string chart_section(const std::string& title, const std::vector<std::string>& charts,
                          const std::string& when_empty) {
  if (charts.empty()) return section(title, "<p class=\"soft\">" + escape(when_empty) + "</p>\n");
  std::string content = "<div class=\"charts\">\n";
  for (const std::string& chart : charts) content += "<figure>" + chart + "</figure>\n";
  return section(title, content + "</div>\n");
}

std::string map_section(const ReportData& data) {
  const std::string plan = plan_picture(data);
  if (plan.empty()) return section("Map", "<p class=\"soft\">There is neither a map nor a path.</p>\n");
  return section("Map", "<figure class=\"plan-figure\">" + plan +
                            "<figcaption class=\"soft\">The laser's map frame: x to the right, y up. White is free, "
                            "black is occupied (the reverse in dark mode), gray is unknown. A dot marks each path's "
                            "end.</figcaption></figure>\n");
}

std::string structure_section(const ReportData& data) {
  const std::string above = structure_picture(data.visual_map, ViewPoint::kAbove);
  if (above.empty()) return "";
  return section("Structure and motion",
                 "<div class=\"charts\">\n<figure>" + above +
                     "<figcaption class=\"soft\">From above.</figcaption></figure>\n<figure>" +
                     structure_picture(data.visual_map, ViewPoint::kSide) +
                     "<figcaption class=\"soft\">From the side, z up.</figcaption></figure>\n</div>\n"
                     "<p class=\"soft\">The visual map in its own frame: what the cameras have recovered without the "
                     "laser. An ellipse holds two standard deviations of a landmark's position.</p>\n");
}

std::string features_section(const ReportData& data) {
  std::string figures;
  for (const common::AnnotatedImage& image : data.sample_images) {
    const std::string overlay = feature_overlay(image);
    if (overlay.empty()) continue;
    figures += fmt::format("<figure>{}<figcaption class=\"soft\">{} at {} s: {}</figcaption></figure>\n", overlay,
                           escape(image.image.sensor), number(common::to_seconds(image.image.stamp - data.start), 1),
                           escape(features_in_words(image)));
  }
  if (figures.empty()) return "";
  return section("What the cameras saw",
                 "<figure class=\"legend\">" + feature_legend() +
                     "<figcaption class=\"soft\">Followed from the camera's image before; "
                     "recognised after having been out of sight; found but rejected, because it "
                     "does not fit the map; entered into the map by this image.</figcaption>"
                     "</figure>\n<div class=\"images\">\n" +
                     figures + "</div>\n");
}

}  // namespace

std::string make_report(const ReportData& data) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>"
         "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"/>"
         "<title>slamfuse: " +
         escape(data.recording) + "</title><style>\n" + chart_style() + kPageStyle + "</style></head><body>\n" +
         header(data) + map_section(data) + section("Accuracy", accuracy_table(data)) +
         chart_section("Error over time", error_charts(data), "No ground truth lies beside the recording.") +
         structure_section(data) + features_section(data) +
         section("Alignment of the visual with the laser path", alignment_table(data)) +
         chart_section("State over time", state_charts(data), "No estimator gave a pose.") +
         chart_section("Health over time", health_charts(data), "No health figures were measured.") +
         section("Modules", module_table(data)) +
         chart_section("Computing time", update_charts(data), "No update was timed.") +
         section("Events", event_table(data)) + "</body></html>\n";
}

}  // namespace slamfuse::service
