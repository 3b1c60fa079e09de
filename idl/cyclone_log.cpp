// SPDX-License-Identifier: BSD-3-Clause
#include "idl/cyclone_log.hpp"

#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

#include <dds/ddsrt/log.h>

namespace slamfuse::idl {
namespace {

constexpr std::size_t kMaxLines = 5;

struct Lines {
  std::mutex mutex;
  std::deque<std::string> newest;
};

// Never destroyed: Cyclone's threads may log until the process ends.
Lines& lines() {
  static auto* const instance = new Lines;
  return *instance;
}

// `message` starts behind the time stamp, domain and thread name of the line.
void keep(void* /*unused*/, const dds_log_data_t* data) {
  std::string line(data->message, data->size);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  const std::lock_guard lock(lines().mutex);
  lines().newest.push_back(std::move(line));
  if (lines().newest.size() > kMaxLines) lines().newest.pop_front();
}

}  // namespace

void capture_cyclone_log() {
  static std::once_flag once;
  std::call_once(once, [] { dds_set_log_sink(&keep, nullptr); });
}

std::string take_cyclone_log() {
  const std::lock_guard lock(lines().mutex);
  std::string text;
  for (const std::string& line : std::exchange(lines().newest, {})) text += (text.empty() ? "" : "; ") + line;
  return text;
}

}  // namespace slamfuse::idl
