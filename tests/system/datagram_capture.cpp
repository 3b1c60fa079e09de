// SPDX-License-Identifier: BSD-3-Clause
#include "system/datagram_capture.hpp"

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstring>
#include <utility>

namespace slamfuse::system {

std::optional<Datagram> datagram_in(const std::uint8_t* frame, std::size_t size) {
  constexpr std::size_t kEthernet = sizeof(ether_header);
  ip header{};
  if (size < kEthernet + sizeof(header)) return std::nullopt;
  std::memcpy(&header, frame + kEthernet, sizeof(header));
  const std::size_t words = header.ip_hl;
  const std::size_t total = ntohs(header.ip_len);
  if (header.ip_v != 4 || header.ip_p != IPPROTO_UDP || words < 5) return std::nullopt;
  if (total < 4 * words || kEthernet + total > size) return std::nullopt;
  Datagram datagram;
  datagram.destination.sin_family = AF_INET;
  datagram.destination.sin_addr = header.ip_dst;
  const std::uint8_t* begin = frame + kEthernet + 4 * words;
  const std::uint8_t* const end = frame + kEthernet + total;
  const bool first = (ntohs(header.ip_off) & IP_OFFMASK) == 0;
  udphdr udp{};
  if (first && begin + sizeof(udp) <= end) {
    std::memcpy(&udp, begin, sizeof(udp));
    datagram.destination.sin_port = udp.dest;
    begin += sizeof(udp);
  }
  datagram.payload.assign(begin, end);
  return datagram;
}

std::unique_ptr<DatagramCapture> DatagramCapture::start(const std::string& interface, std::size_t most) {
  const int socket = ::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, htons(ETH_P_IP));
  if (socket < 0) return nullptr;
  sockaddr_ll where{};
  where.sll_family = AF_PACKET;
  where.sll_protocol = htons(ETH_P_IP);
  where.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  const timeval nap{0, 50'000};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &nap, sizeof(nap));
  if (where.sll_ifindex == 0 || bind(socket, reinterpret_cast<const sockaddr*>(&where), sizeof(where)) != 0) {
    close(socket);
    return nullptr;
  }
  return std::unique_ptr<DatagramCapture>(new DatagramCapture(socket, most));
}

DatagramCapture::DatagramCapture(int socket, std::size_t most) : socket_(socket) {
  thread_ = std::jthread([this, most](const std::stop_token& done) {
    std::vector<std::uint8_t> frame(1U << 17);
    while (!done.stop_requested()) {
      const ssize_t size = recv(socket_, frame.data(), frame.size(), 0);
      if (size <= 0 || heard_.size() >= most) continue;
      if (auto datagram = datagram_in(frame.data(), static_cast<std::size_t>(size))) {
        heard_.push_back(*std::move(datagram));
      }
    }
  });
}

DatagramCapture::~DatagramCapture() {
  stop();
  close(socket_);
}

std::vector<Datagram> DatagramCapture::stop() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  return std::exchange(heard_, {});
}

}  // namespace slamfuse::system
