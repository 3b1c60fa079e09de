// SPDX-License-Identifier: BSD-3-Clause
// The figures the project promises, measured with the real program: a table bar | measured | pass. Recordings that are
// not in the repository are looked for through SLAMFUSE_RECORDINGS and skipped, saying so, without it.
//
//     benchmark_bars [SUBSTRING]     only the bars whose name contains it
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "benchmark/bar_table.hpp"
#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A run that must end well; false (and a failed row) if it did not.
bool ran(BarTable& table, const std::string& name, const std::vector<std::string>& arguments) {
  const Outcome outcome = run_program(arguments);
  if (outcome.exit_status == 0) return true;
  table.judge(name, "exit 0", fmt::format("exit {}: {}", outcome.exit_status, outcome.err), false);
  return false;
}

bool same_trajectories(const fs::path& a, const fs::path& b) {
  for (const auto& name : names_in(a)) {
    if (name.ends_with(".tum") && read_text(a / name) != read_text(b / name)) return false;
  }
  return true;
}

void measure_flat(BarTable& table, const Scratch& scratch) {
  const fs::path one = scratch / "flat_one";
  const fs::path two = scratch / "flat_two";
  const fs::path again = scratch / "flat_again";
  if (!ran(table, "flat", {"run", flat().string(), "-o", two.string(), "--threads", "2"})) return;
  const json metrics = read_json(two / "metrics.json");
  const json& accuracy = metrics["accuracy"];
  for (const char* source : {"laser", "visual", "fused"}) {
    table.at_least(fmt::format("flat: coverage of {}", source), accuracy[source]["coverage"], 0.98);
  }
  table.show("flat: ATE of odometry [m]", fmt::format("{:.4f}", accuracy["odometry"]["ate_rmse_m"].get<double>()));
  table.at_most("flat: ATE of laser.tum [m]", accuracy["laser"]["ate_rmse_m"], 0.05);
  table.at_most("flat: ATE of visual.tum [m]", accuracy["visual"]["ate_rmse_m"], 0.20);
  table.at_most("flat: ATE of fused.tum [m]", accuracy["fused"]["ate_rmse_m"], 0.05);
  table.at_least("flat: real-time factor", metrics["real_time_factor"], 2.0);

  if (!ran(table, "flat again", {"run", flat().string(), "-o", again.string(), "--threads", "2"})) return;
  const bool repeats = same_trajectories(two, again);
  table.judge("flat: same .tum files twice", "identical", repeats ? "identical" : "different", repeats);
  if (!ran(table, "flat, one thread", {"run", flat().string(), "-o", one.string(), "--threads", "1"})) return;
  const bool threads = same_trajectories(two, one);
  table.judge("flat: same .tum files with 1 and 2 threads", "identical", threads ? "identical" : "different", threads);
}

bool has_event(const json& metrics, const std::string& kind) {
  for (const auto& event : metrics["events"]) {
    if (event["kind"] == kind) return true;
  }
  return false;
}

void measure_rawlog(BarTable& table, const Scratch& scratch) {
  const fs::path log = "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
  if (!fs::exists(log)) return table.skip("rawlog: laser-only run", "no " + log.string());
  const fs::path out = scratch / "rawlog";
  if (!ran(table, "rawlog", {"run", log.string(), "-o", out.string(), "--modules", "laser"})) return;
  const bool closed = has_event(read_json(out / "metrics.json"), "loop_closed");
  table.judge("rawlog: laser-only run", "loop closed", closed ? "loop closed" : "no loop closed", closed);
}

void measure_intel(BarTable& table, const Scratch& scratch, const fs::path& recordings) {
  const fs::path radish = recordings / "real/radish";
  const fs::path out = scratch / "intel";
  if (!ran(table, "intel", {"run", (radish / "intel.clf.bz2").string(), "-o", out.string(), "--modules", "laser"}))
    return;
  const std::string path = (out / "laser_final.tum").string();
  const Outcome outcome = run_program({"evaluate", path, (radish / "intel.reference.txt").string(), "--relations",
                                       (radish / "intel.relations").string(), "--json"});
  if (outcome.exit_status != 0) return table.judge("intel: evaluate", "exit 0", outcome.err, false);
  const json result = json::parse(outcome.out);
  table.at_most("intel: ATE of laser_final [m]", result["ate_rmse_m"], 0.30);
  const json& all = result["relations"]["all"];
  table.judge("intel: relations", "matched",
              fmt::format("{} matched, {:.3f} +- {:.3f} m", all["matched"].get<int>(),
                          all["translation_m"]["mean"].get<double>(), all["translation_m"]["deviation"].get<double>()),
              all["matched"] > 0);
}

void measure_calib2d(BarTable& table, const Scratch& scratch, const fs::path& recordings) {
  const fs::path folder = recordings / "real/calib2d_mapir";
  const fs::path out = scratch / "calib2d";
  if (!ran(table, "calib2d",
           {"align", (folder / "laser.txt").string(), (folder / "camera.txt").string(), "-o", out.string(), "--method",
            "similarity"})) {
    return;
  }
  const json alignment = read_json(out / "metrics.json")["alignment"];
  const double scale = alignment["scale"][0];
  table.judge("calib2d: scale, camera against laser", "0.243 within 1 %", fmt::format("{:.5f}", scale),
              std::abs(scale / 0.243 - 1.0) <= 0.01);
  table.at_most("calib2d: residual [m]", alignment["rmse_m"], 0.033);
}

int measure_all(const std::string& only) {
  BarTable table(only);
  const Scratch scratch;
  table.print_head();
  if (table.wants("flat")) measure_flat(table, scratch);
  if (table.wants("rawlog")) measure_rawlog(table, scratch);
  const char* recordings = std::getenv("SLAMFUSE_RECORDINGS");
  using Measure = void (*)(BarTable&, const Scratch&, const fs::path&);
  constexpr std::array<std::pair<const char*, Measure>, 2> kOnRealRecordings{
      {{"intel", measure_intel}, {"calib2d", measure_calib2d}}};
  for (const auto& [name, measure] : kOnRealRecordings) {
    if (!table.wants(name)) continue;
    if (recordings == nullptr) {
      table.skip(name, "SLAMFUSE_RECORDINGS not set");
    } else {
      measure(table, scratch, recordings);
    }
  }
  return table.exit_status();
}

}  // namespace
}  // namespace slamfuse::system

int main(int argc, char** argv) { return slamfuse::system::measure_all(argc > 1 ? argv[1] : ""); }
