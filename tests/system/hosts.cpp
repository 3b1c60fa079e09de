// SPDX-License-Identifier: BSD-3-Clause
#include "system/hosts.hpp"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cstdlib>

#include "system/child_process.hpp"

namespace slamfuse::system {
namespace {

bool ip(const std::string& words) { return std::system(("ip " + words + " 2>/dev/null").c_str()) == 0; }

std::string prefix() { return "slamfuse-" + std::to_string(getpid()) + "-"; }

}  // namespace

std::unique_ptr<Hosts> Hosts::create(const std::vector<std::string>& names, std::string& why_not) {
  std::unique_ptr<Hosts> hosts(new Hosts);
  hosts->home_ = open("/proc/self/ns/net", O_RDONLY | O_CLOEXEC);
  const auto make = [&](const std::string& host) {
    const std::string name = hosts->name_of(host);
    if (!ip("netns add " + name)) return false;
    hosts->made_.push_back(name);
    return ip("-n " + name + " link set lo up");
  };
  const std::string hub = hosts->name_of("hub");
  // Without a querier a bridge that looks into multicast would let discovery through at the beginning only.
  if (!make("hub") || !ip("-n " + hub + " link add name hub0 type bridge mcast_snooping 0") ||
      !ip("-n " + hub + " link set hub0 up")) {
    why_not = "no network namespace with a bridge can be made here (it takes iproute2 and root)";
    return nullptr;
  }
  int number = 0;
  for (const std::string& host : names) {
    const std::string name = hosts->name_of(host);
    const std::string port = "port" + std::to_string(++number);
    const std::string address = "10.77.0." + std::to_string(number) + "/24";
    if (!make(host) || !ip("link add " + port + " netns " + hub + " type veth peer name eth0 netns " + name) ||
        !ip("-n " + hub + " link set " + port + " master hub0 up") ||
        !ip("-n " + name + " addr add " + address + " dev eth0") || !ip("-n " + name + " link set eth0 up")) {
      why_not = "the namespace " + name + " cannot be joined to the bridge";
      return nullptr;
    }
  }
  return hosts;
}

Hosts::~Hosts() {
  for (const std::string& name : made_) ip("netns del " + name);
  if (home_ >= 0) close(home_);
}

pid_t Hosts::start(const std::string& host, std::vector<std::string> words) const {
  words.insert(words.begin(), {"/usr/bin/nsenter", "--net=/run/netns/" + name_of(host)});
  return system::start(std::move(words));
}

bool Hosts::enter(const std::string& host) const {
  const int there = open(("/run/netns/" + name_of(host)).c_str(), O_RDONLY | O_CLOEXEC);
  if (there < 0) return false;
  const bool entered = setns(there, CLONE_NEWNET) == 0;
  close(there);
  return entered;
}

void Hosts::leave() const { static_cast<void>(setns(home_, CLONE_NEWNET)); }

std::string Hosts::name_of(const std::string& host) const { return prefix() + host; }

}  // namespace slamfuse::system
