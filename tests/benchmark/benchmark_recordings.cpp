// SPDX-License-Identifier: BSD-3-Clause
// How fast recordings are read, images decoded. Finds the recordings through SLAMFUSE_RECORDINGS.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/recording.hpp"

namespace {

void read_recording(benchmark::State& state, const std::string& name) {
  const char* const root = std::getenv("SLAMFUSE_RECORDINGS");
  if (root == nullptr) {
    state.SkipWithError("SLAMFUSE_RECORDINGS is not set");
    return;
  }
  double seconds = 0.0;
  for (auto _ : state) {
    const auto recording = slamfuse::common::open_recording(std::filesystem::path(root) / name);
    if (!recording) {
      state.SkipWithError(recording.error().message.c_str());
      return;
    }
    const slamfuse::common::RecordingInfo& info = (*recording)->info();
    while (true) {
      const auto item = (*recording)->next();
      if (!item || !*item) break;
    }
    seconds += slamfuse::common::to_seconds(info.last_stamp - info.first_stamp);
  }
  state.counters["times_real_time"] = benchmark::Counter(seconds, benchmark::Counter::kIsRate);
}

BENCHMARK_CAPTURE(read_recording, flat, "sim/flat")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_recording, intel, "real/radish/intel.clf.bz2")->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
