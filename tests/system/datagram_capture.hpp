// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace slamfuse::system {

/// A UDP datagram as it was on the wire.
struct Datagram {
  sockaddr_in destination{};
  std::vector<std::uint8_t> payload;
};

/// Hears all UDP datagrams over IPv4 on an interface, whoever they are for, in a thread of its own. Fragments of larger
/// datagrams are kept as they are, the later ones without their port. Needs the right to open raw sockets.
class DatagramCapture {
 public:
  /// Keeps the first `most`. Null where raw sockets are not allowed.
  static std::unique_ptr<DatagramCapture> start(const std::string& interface, std::size_t most);
  ~DatagramCapture();
  DatagramCapture(const DatagramCapture&) = delete;
  DatagramCapture& operator=(const DatagramCapture&) = delete;

  /// Ends it and gives what was heard.
  std::vector<Datagram> stop();

 private:
  DatagramCapture(int socket, std::size_t most);
  int socket_;
  std::vector<Datagram> heard_;
  std::jthread thread_;
};

/// The datagram in an Ethernet frame; nothing when it holds none over IPv4.
std::optional<Datagram> datagram_in(const std::uint8_t* frame, std::size_t size);

}  // namespace slamfuse::system
