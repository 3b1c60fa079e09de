// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

namespace slamfuse::system {

/// Hosts on one network, as network namespaces joined by a bridge; gone with the object. Needs the right to make them.
class Hosts {
 public:
  /// Null, with the reason in `why_not`, where the system does not let us or lacks `ip` (iproute2).
  static std::unique_ptr<Hosts> create(const std::vector<std::string>& names, std::string& why_not);
  ~Hosts();
  Hosts(const Hosts&) = delete;
  Hosts& operator=(const Hosts&) = delete;

  /// Starts a program there; -1 when it cannot be.
  pid_t start(const std::string& host, std::vector<std::string> words) const;
  /// Puts the calling thread, and those it starts from then on, there. False when it cannot be.
  bool enter(const std::string& host) const;
  /// Puts it back to where the test started.
  void leave() const;

 private:
  Hosts() = default;
  std::string name_of(const std::string& host) const;
  std::vector<std::string> made_;  // names of the namespaces
  int home_ = -1;                  // descriptor of the test's own namespace
};

}  // namespace slamfuse::system
