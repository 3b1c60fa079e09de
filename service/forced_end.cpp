// SPDX-License-Identifier: BSD-3-Clause
#include "service/forced_end.hpp"

#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <thread>

namespace slamfuse::service {

void force_end(std::chrono::nanoseconds patience, const std::string& last_words, int exit_status) {
  static std::atomic_flag armed = ATOMIC_FLAG_INIT;
  if (armed.test_and_set()) return;
  // Detached: it outlives main() and whatever hangs there, and goes with the process where nothing does.
  std::thread([patience, last_words, exit_status] {
    std::this_thread::sleep_for(patience);
    // Not through stdio: who hangs may hold its lock.
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, last_words.data(), last_words.size());
    std::_Exit(exit_status);
  }).detach();
}

}  // namespace slamfuse::service
