// SPDX-License-Identifier: BSD-3-Clause
// The figures the project promises, measured with the real program: a table bar | measured | pass. Recordings that are
// not in the repository are looked for through SLAMFUSE_RECORDINGS and skipped, saying so, without it.
//
//     benchmark_bars [SUBSTRING]     only the bars whose name contains it
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

int failures = 0;
std::string only;

bool is_wanted(const std::string& name) { return name.find(only) != std::string::npos; }

void print_row(const std::string& name, const std::string& bar, const std::string& measured, const char* verdict) {
  fmt::print("| {:<44} | {:<22} | {:<28} | {:<7} |\n", name, bar, measured, verdict);
  std::fflush(stdout);
}

void judge(const std::string& name, const std::string& bar, const std::string& measured, bool pass) {
  if (!pass) ++failures;
  print_row(name, bar, measured, pass ? "pass" : "FAIL");
}

void at_least(const std::string& name, double measured, double bar) {
  judge(name, fmt::format(">= {}", bar), fmt::format("{:.4f}", measured), measured >= bar);
}

void at_most(const std::string& name, double measured, double bar) {
  judge(name, fmt::format("<= {}", bar), fmt::format("{:.4f}", measured), measured <= bar);
}

/// A run that must end well; false (and a failed row) if it did not.
bool ran(const std::string& name, const std::vector<std::string>& arguments) {
  const Outcome outcome = run_program(arguments);
  if (outcome.exit_status == 0) return true;
  judge(name, "exit 0", fmt::format("exit {}: {}", outcome.exit_status, outcome.err), false);
  return false;
}

bool same_trajectories(const fs::path& a, const fs::path& b) {
  for (const auto& name : names_in(a)) {
    if (name.ends_with(".tum") && read_text(a / name) != read_text(b / name)) return false;
  }
  return true;
}

void measure_flat(const Scratch& scratch) {
  const fs::path one = scratch / "flat_one";
  const fs::path two = scratch / "flat_two";
  const fs::path again = scratch / "flat_again";
  if (!ran("flat", {"run", flat().string(), "-o", two.string(), "--threads", "2"})) return;
  const json metrics = read_json(two / "metrics.json");
  const json& accuracy = metrics["accuracy"];
  for (const char* source : {"laser", "visual", "fused"}) {
    at_least(fmt::format("flat: coverage of {}", source), accuracy[source]["coverage"], 0.98);
  }
  print_row("flat: ATE of odometry [m]", "(shown)",
            fmt::format("{:.4f}", accuracy["odometry"]["ate_rmse_m"].get<double>()), "");
  at_most("flat: ATE of laser.tum [m]", accuracy["laser"]["ate_rmse_m"], 0.05);
  at_most("flat: ATE of visual.tum [m]", accuracy["visual"]["ate_rmse_m"], 0.20);
  at_most("flat: ATE of fused.tum [m]", accuracy["fused"]["ate_rmse_m"], 0.05);
  at_least("flat: real-time factor", metrics["real_time_factor"], 2.0);

  if (!ran("flat again", {"run", flat().string(), "-o", again.string(), "--threads", "2"})) return;
  const bool repeats = same_trajectories(two, again);
  judge("flat: same .tum files twice", "identical", repeats ? "identical" : "different", repeats);
  if (!ran("flat, one thread", {"run", flat().string(), "-o", one.string(), "--threads", "1"})) return;
  const bool threads = same_trajectories(two, one);
  judge("flat: same .tum files with 1 and 2 threads", "identical", threads ? "identical" : "different", threads);
}

bool has_event(const json& metrics, const std::string& kind) {
  for (const auto& event : metrics["events"]) {
    if (event["kind"] == kind) return true;
  }
  return false;
}

void measure_rawlog(const Scratch& scratch) {
  const fs::path log = "/usr/share/mrpt/datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
  if (!fs::exists(log)) return print_row("rawlog: laser-only run", "loop closed", "no " + log.string(), "skipped");
  const fs::path out = scratch / "rawlog";
  if (!ran("rawlog", {"run", log.string(), "-o", out.string(), "--modules", "laser"})) return;
  const bool closed = has_event(read_json(out / "metrics.json"), "loop_closed");
  judge("rawlog: laser-only run", "loop closed", closed ? "loop closed" : "no loop closed", closed);
}

void measure_intel(const Scratch& scratch, const fs::path& recordings) {
  const fs::path radish = recordings / "real/radish";
  const fs::path out = scratch / "intel";
  if (!ran("intel", {"run", (radish / "intel.clf.bz2").string(), "-o", out.string(), "--modules", "laser"})) return;
  const std::string path = (out / "laser_final.tum").string();
  const Outcome outcome = run_program({"evaluate", path, (radish / "intel.reference.txt").string(), "--relations",
                                       (radish / "intel.relations").string(), "--json"});
  if (outcome.exit_status != 0) return judge("intel: evaluate", "exit 0", outcome.err, false);
  const json result = json::parse(outcome.out);
  at_most("intel: ATE of laser_final [m]", result["ate_rmse_m"], 0.30);
  const json& all = result["relations"]["all"];
  judge("intel: relations", "matched",
        fmt::format("{} matched, {:.3f} +- {:.3f} m", all["matched"].get<int>(),
                    all["translation_m"]["mean"].get<double>(), all["translation_m"]["deviation"].get<double>()),
        all["matched"] > 0);
}

void measure_calib2d(const Scratch& scratch, const fs::path& recordings) {
  const fs::path folder = recordings / "real/calib2d_mapir";
  const fs::path out = scratch / "calib2d";
  if (!ran("calib2d", {"align", (folder / "laser.txt").string(), (folder / "camera.txt").string(), "-o", out.string(),
                       "--method", "similarity"})) {
    return;
  }
  const json alignment = read_json(out / "metrics.json")["alignment"];
  const double scale = alignment["scale"][0];
  judge("calib2d: scale, camera against laser", "0.243 within 1 %", fmt::format("{:.5f}", scale),
        std::abs(scale / 0.243 - 1.0) <= 0.01);
  at_most("calib2d: residual [m]", alignment["rmse_m"], 0.033);
}

int measure_all() {
  const Scratch scratch;
  print_row("what", "bar", "measured", "verdict");
  fmt::print("|{:-<46}|{:-<24}|{:-<30}|{:-<9}|\n", "", "", "", "");
  if (is_wanted("flat")) measure_flat(scratch);
  if (is_wanted("rawlog")) measure_rawlog(scratch);
  const char* recordings = std::getenv("SLAMFUSE_RECORDINGS");
  using Measure = void (*)(const Scratch&, const fs::path&);
  constexpr std::array<std::pair<const char*, Measure>, 2> kOnRealRecordings{
      {{"intel", measure_intel}, {"calib2d", measure_calib2d}}};
  for (const auto& [name, measure] : kOnRealRecordings) {
    if (!is_wanted(name)) continue;
    if (recordings == nullptr) {
      print_row(name, "", "SLAMFUSE_RECORDINGS not set", "skipped");
    } else {
      measure(scratch, recordings);
    }
  }
  return failures == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

}  // namespace
}  // namespace slamfuse::system

int main(int argc, char** argv) {
  if (argc > 1) slamfuse::system::only = argv[1];
  return slamfuse::system::measure_all();
}
