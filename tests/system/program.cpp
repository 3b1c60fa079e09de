// SPDX-License-Identifier: BSD-3-Clause
#include "system/program.hpp"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace slamfuse::system {
namespace {

using Clock = std::chrono::steady_clock;

std::string content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void send_to(int stream, const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ::dup2(file, stream);
}

[[noreturn]] void become_program(const Launch& launch, const std::filesystem::path& out,
                                 const std::filesystem::path& err) {
  send_to(STDOUT_FILENO, out);
  send_to(STDERR_FILENO, err);
  if (launch.largest_file) {
    const rlimit limit{*launch.largest_file, *launch.largest_file};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  std::vector<char*> arguments{const_cast<char*>(SLAMFUSE_PROGRAM)};
  for (const auto& argument : launch.arguments) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  ::execv(SLAMFUSE_PROGRAM, arguments.data());
  std::_Exit(127);
}

}  // namespace

Outcome run_program(const Launch& launch) {
  std::string folder = (std::filesystem::temp_directory_path() / "slamfuse-program-XXXXXX").string();
  ::mkdtemp(folder.data());
  const std::filesystem::path out = std::filesystem::path(folder) / "out";
  const std::filesystem::path err = std::filesystem::path(folder) / "err";

  auto start = Clock::now();
  const pid_t child = ::fork();
  if (child == 0) become_program(launch, out, err);
  if (launch.interrupt_after) {
    std::this_thread::sleep_for(std::chrono::duration<double>(*launch.interrupt_after));
    ::kill(child, SIGINT);
    start = Clock::now();
  }
  int status = 0;
  ::waitpid(child, &status, 0);

  Outcome outcome;
  outcome.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  outcome.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  outcome.out = content_of(out);
  outcome.err = content_of(err);
  std::filesystem::remove_all(folder);
  return outcome;
}

Outcome run_program(const std::vector<std::string>& arguments) { return run_program(Launch{arguments, {}, {}}); }

}  // namespace slamfuse::system
