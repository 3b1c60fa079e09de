// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace slamfuse::system {

/// Starts a program beside the test, with the test's environment; -1 when it cannot be.
inline pid_t start(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  return posix_spawn(&child, arguments[0], nullptr, nullptr, arguments.data(), environ) == 0 ? child : -1;
}

/// Waits for its end; -1 when a signal ended it.
inline int exit_status_of(pid_t child) {
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Waits until something is true.
template <class Condition>
bool becomes_true(const Condition& condition, std::chrono::seconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

inline bool appears(const std::filesystem::path& file, std::chrono::seconds patience) {
  return becomes_true([&] { return std::filesystem::exists(file); }, patience);
}

}  // namespace slamfuse::system
