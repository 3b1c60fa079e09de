// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <thread>
#include <vector>

namespace slamfuse::laser_slam {

/// Calls work(i, worker) for i in [0, count), split evenly over `threads` threads that end before it returns. The
/// calling thread is worker 0. Calls must not depend on one another; `work` must not throw.
template <class Work>
void parallel_for(int count, int threads, const Work& work) {
  const int workers = std::max(1, std::min(threads, count));
  const auto run = [&](int worker) {
    for (int i = count * worker / workers; i < count * (worker + 1) / workers; ++i) work(i, worker);
  };
  std::vector<std::jthread> others;
  for (int worker = 1; worker < workers; ++worker) others.emplace_back(run, worker);
  run(0);
}

}  // namespace slamfuse::laser_slam
