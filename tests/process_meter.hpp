// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <malloc.h>

#include <ctime>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>

namespace slamfuse {

/// Processor time of this process so far, of all its threads [s].
inline double process_cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// A line of /proc/self/status in bytes, e.g. "VmRSS:".
inline double process_memory(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) return 1024.0 * std::stod(line.substr(key.size()));
  }
  return 0.0;
}

/// What a piece of work took.
struct WorkCost {
  double cpu_seconds = 0.0;
  double kept_bytes = 0.0;  ///< resident memory after it, beyond that before
  double peak_bytes = 0.0;  ///< the most during it, beyond that before
};

/// Does some work and measures it by the kernel's figures, so that whatever allocates is counted.
template <class Work>
WorkCost measure(const Work& work) {
  malloc_trim(0);  // what was freed before must not serve the work unseen
  std::ofstream("/proc/self/clear_refs") << "5";
  const double before = process_memory("VmRSS:");
  const double began = process_cpu_seconds();
  work();
  const double took = process_cpu_seconds() - began;
  const double peak = process_memory("VmHWM:");
  malloc_trim(0);
  return {took, process_memory("VmRSS:") - before, std::max(0.0, peak - before)};
}

}  // namespace slamfuse
