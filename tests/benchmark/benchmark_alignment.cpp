// SPDX-License-Identifier: BSD-3-Clause
// Time of one alignment of 10 000 pairs with each method, and of one corrected pose.

#include <benchmark/benchmark.h>

#include "fusion/alignment.hpp"
#include "fusion/fusion.hpp"
#include "fusion/simulated_drive.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace {

using namespace slamfuse;

void align(benchmark::State& state, fusion::AlignmentMethod method) {
  const auto laser = fusion::flat_path(static_cast<std::size_t>(state.range(0)));
  const auto visual = fusion::visual_path(laser, fusion::stretched_map(37.0, 2.0, 2.1, 1.0, 2.0), 0.01, 0.1, 1);
  fusion::AlignmentOptions options;
  options.method = method;
  for (auto _ : state) benchmark::DoNotOptimize(fusion::align_trajectories(laser, visual, options));
}

void fit_once(benchmark::State& state, bool seed004, double outliers) {
  const auto laser = fusion::flat_path(static_cast<std::size_t>(state.range(0)));
  const auto visual = fusion::visual_path(laser, fusion::stretched_map(37.0, 2.0, 2.1, 1.0, 2.0), 0.01, outliers, 1);
  const auto pairs = fusion::pair_trajectories(laser, visual, {});
  for (auto _ : state) {
    if (seed004) {
      benchmark::DoNotOptimize(fusion::fit_seed004(pairs, {}, 10, 0.35));
    } else {
      benchmark::DoNotOptimize(fusion::fit_robust(pairs, fusion::RobustModel::kSimilarity, {}, 0.35));
    }
  }
}

void corrected_pose(benchmark::State& state) {
  const auto fused = fusion::Fusion::create({});
  fusion::SimulatedDrive drive;
  int step = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize((*fused)->process(drive.odometry(step)));
    if (step % 4 == 0) benchmark::DoNotOptimize((*fused)->process(drive.laser(step)));
    ++step;
  }
}

}  // namespace

BENCHMARK_CAPTURE(align, auto, fusion::AlignmentMethod::kAuto) -> Arg(10000) -> Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align, similarity, fusion::AlignmentMethod::kSimilarity)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align, affine, fusion::AlignmentMethod::kAffine)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(align, seed004, fusion::AlignmentMethod::kSeed004)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fit_once, similarity, false, 0.1)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fit_once, seed004_clean, true, 0.0)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(fit_once, seed004, true, 0.1)->Arg(10000)->Unit(benchmark::kMillisecond);
BENCHMARK(corrected_pose)->Unit(benchmark::kMicrosecond);

BENCHMARK_MAIN();
