// SPDX-License-Identifier: BSD-3-Clause
// Corrupted RTPS datagrams into a running `serve` while a robot's messages go on: does it live, what does it keep, what
// does it say, are its poses right?
//
//     benchmark_datagrams [--count N] [--rate PER_SECOND] [--seed N] [--spoofed FRACTION] [--program SLAMFUSE]
//
// The datagrams are those of its first seconds, heard on loopback, each changed in one of seven ways and sent to a port
// of the service or to its multicast group. At first they come from participants that do not exist, in the last part
// (--spoofed, 0.2) as if from those that do: then streams may stall, but no wrong pose may come. Needs the right to
// open raw sockets.
// With ROS_SECURITY_ENABLE=true and ROS_SECURITY_KEYSTORE (scripts/keystore) all of it is secured.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "idl/reader.hpp"
#include "service/ros_conversion.hpp"
#include "system/child_process.hpp"
#include "system/datagram_capture.hpp"
#include "system/network.hpp"

namespace {

namespace fs = std::filesystem;
using namespace slamfuse;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using system::Datagram;
using Bytes = std::vector<std::uint8_t>;

const std::string kFlat = SLAMFUSE_DATA_DIR "/flat";
// RTPS: "RTPS", version, vendor, then the sender's 12 bytes.
constexpr std::size_t kPrefixAt = 8;
constexpr std::size_t kPrefixSize = 12;
constexpr std::size_t kHeaderSize = kPrefixAt + kPrefixSize;

struct Settings {
  int count = 1'000'000;
  double rate = 9000.0;
  unsigned seed = 1;
  double spoofed = 0.2;
  std::string program = SLAMFUSE_PROGRAM;
};

Settings settings_of(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--count") settings.count = std::atoi(argv[i + 1]);
    if (word == "--rate") settings.rate = std::atof(argv[i + 1]);
    if (word == "--seed") settings.seed = static_cast<unsigned>(std::atoi(argv[i + 1]));
    if (word == "--spoofed") settings.spoofed = std::atof(argv[i + 1]);
    if (word == "--program") settings.program = argv[i + 1];
  }
  return settings;
}

/// Changes datagrams, the same way for the same seed.
class Corruption {
 public:
  Corruption(const std::vector<Datagram>& samples, unsigned seed) : samples_(samples), random_(seed) {}

  /// A sample, changed; `spoofed`: its sender stays the one it had.
  Datagram next(bool spoofed) {
    Datagram datagram = samples_[below(samples_.size())];
    Bytes& bytes = datagram.payload;
    if (!spoofed) {
      for (std::size_t i = 0; i < kPrefixSize; ++i) bytes[kPrefixAt + i] = byte();
    }
    const std::size_t changes = 1 + below(8);
    switch (below(7)) {
      case 0:
        for (std::size_t i = 0; i < changes; ++i) bytes[at(bytes)] ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 1:
        for (std::size_t i = 0; i < changes; ++i) bytes[at(bytes)] = byte();
        break;
      case 2:
        bytes.resize(kHeaderSize + below(bytes.size() - kHeaderSize + 1));
        break;
      case 3:
        for (std::size_t i = 0; i < 4 * changes; ++i) bytes.push_back(byte());
        break;
      case 4:
        write_number(bytes);
        break;
      case 5: {  // the end of another one
        const Bytes& other = samples_[below(samples_.size())].payload;
        bytes.resize(kHeaderSize + below(bytes.size() - kHeaderSize + 1));
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(at(other)), other.end());
        break;
      }
      default: {  // a piece of itself again
        const std::size_t begin = at(bytes);
        const Bytes piece(bytes.begin() + static_cast<std::ptrdiff_t>(begin), bytes.end());
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at(bytes)), piece.begin(), piece.end());
      }
    }
    constexpr std::size_t kLargest = 65000;
    if (bytes.size() > kLargest) bytes.resize(kLargest);
    return datagram;
  }

  std::size_t below(std::size_t bound) { return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random_); }

 private:
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }
  /// A place behind the header: a garbled header is not even looked at.
  std::size_t at(const Bytes& bytes) { return kHeaderSize + below(bytes.size() - kHeaderSize); }
  /// A number that lengths and counts are often not ready for.
  void write_number(Bytes& bytes) {
    constexpr std::uint32_t kNumbers[] = {0,      1,          3,          0x7f,       0xff,      0x7fff,
                                          0xffff, 0x7fffffff, 0x80000000, 0xfffffffc, 0xffffffff};
    const std::uint32_t number = kNumbers[below(std::size(kNumbers))];
    const std::size_t size = std::size_t{1} << below(3);
    const std::size_t where = at(bytes);
    std::memcpy(bytes.data() + where, &number, std::min(size, bytes.size() - where));
  }

  const std::vector<Datagram>& samples_;
  std::mt19937_64 random_;
};

/// Resident memory of a process [10^6 bytes]; 0 when it is gone.
double resident_mb(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/statm");
  double pages = 0.0;
  double resident = 0.0;
  file >> pages >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// The UDP ports of a process with what was dropped there because it was too slow.
std::map<std::uint16_t, std::uint64_t> udp_ports_of(pid_t process) {
  std::set<std::string> inodes;
  const std::string folder = "/proc/" + std::to_string(process);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/fd", error)) {
    const std::string link = fs::read_symlink(entry.path(), error).string();
    if (link.starts_with("socket:[")) inodes.insert(link.substr(8, link.size() - 9));
  }
  std::map<std::uint16_t, std::uint64_t> ports;
  std::ifstream table(folder + "/net/udp");
  std::string line;
  std::getline(table, line);  // the heading
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::vector<std::string> columns;
    for (std::string word; words >> word;) columns.push_back(word);
    if (columns.size() < 13 || !inodes.contains(columns[9])) continue;
    const auto port = static_cast<std::uint16_t>(std::stoul(columns[1].substr(columns[1].find(':') + 1), nullptr, 16));
    ports[port] += std::stoull(columns[12]);
  }
  return ports;
}

std::uint64_t drops_of(pid_t process) {
  std::uint64_t sum = 0;
  for (const auto& [port, drops] : udp_ports_of(process)) sum += drops;
  return sum;
}

/// Poses as they come, by stamp.
class Poses {
 public:
  explicit Poses(const idl::Participant& participant)
      : thread_([this, &participant](const std::stop_token& done) {
          auto reader = idl::Reader<idl::PoseWithCovarianceStamped>::create(participant, "slamfuse/pose",
                                                                            idl::QosProfile::kTransformInput);
          while (reader && !done.stop_requested()) {
            const auto message = reader->take(50ms);
            if (!message || !*message) continue;
            const auto& pose = (**message)->pose.pose;
            const std::lock_guard lock(mutex_);
            poses_[service::from_ros_time((**message)->header.stamp)] = {
                pose.position.x, pose.position.y, 2.0 * std::atan2(pose.orientation.z, pose.orientation.w)};
          }
        }) {}

  common::Trajectory2 path() {
    const std::lock_guard lock(mutex_);
    common::Trajectory2 path;
    for (const auto& [stamp, pose] : poses_) path.push_back({stamp, pose});
    return path;
  }

 private:
  std::mutex mutex_;
  std::map<common::Nanoseconds, common::Pose2> poses_;
  std::jthread thread_;
};

/// Sends to loopback, where it was meant to go.
class Sender {
 public:
  Sender() : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    const in_addr loopback{htonl(INADDR_LOOPBACK)};
    setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
  }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  ~Sender() { close(socket_); }
  bool send(const Datagram& datagram) const {
    return sendto(socket_, datagram.payload.data(), datagram.payload.size(), 0,
                  reinterpret_cast<const sockaddr*>(&datagram.destination), sizeof(datagram.destination)) >= 0;
  }

 private:
  int socket_;
};

bool is_rtps(const Datagram& datagram) {
  return datagram.payload.size() > kHeaderSize && std::memcmp(datagram.payload.data(), "RTPS", 4) == 0;
}

std::size_t lines_in(const fs::path& file) {
  std::ifstream text(file);
  return static_cast<std::size_t>(
      std::count(std::istreambuf_iterator<char>(text), std::istreambuf_iterator<char>(), '\n'));
}

}  // namespace

int main(int argc, char** argv) {
  const Settings settings = settings_of(argc, argv);
  const fs::path folder = fs::temp_directory_path() / ("slamfuse-datagrams-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const system::Network network;
  const auto capture = system::DatagramCapture::start("lo", 20'000);
  if (!capture) {
    std::fprintf(stderr, "raw sockets are not allowed here\n");
    return 1;
  }
  const auto participant = *idl::Participant::join(idl::Network::kLoopback);  // secured, where the environment says so
  Poses poses(participant);
  const fs::path log = folder / "serve.log";
  const pid_t service = system::start({"/bin/sh", "-c", "exec \"$0\" \"$@\" 2>\"" + log.string() + "\"",
                                       settings.program, "serve", "-o", folder / "out", "--modules", "laser"});
  const pid_t player = system::start({SLAMFUSE_PROGRAM, "play", kFlat, "--wait", "30"});
  if (!system::becomes_true([&] { return poses.path().size() > 100; }, 60s)) {
    std::fprintf(stderr, "serve gives no poses\n");
    return 1;
  }
  auto samples = capture->stop();
  std::erase_if(samples, [](const Datagram& datagram) { return !is_rtps(datagram); });
  if (samples.empty()) return 1;
  std::vector<std::uint16_t> ports;
  for (const auto& [port, drops] : udp_ports_of(service)) ports.push_back(port);
  std::printf("%zu real datagrams to start from, %zu ports of the service\n", samples.size(), ports.size());

  Corruption corruption(samples, settings.seed);
  const Sender sender;
  std::size_t refused = 0;
  const auto begun = Clock::now();
  const int honest = static_cast<int>((1.0 - settings.spoofed) * settings.count);
  std::printf("%10s %9s %14s %8s %12s %10s\n", "sent", "seconds", "resident [MB]", "poses", "lines of log", "drops");
  int sent = 0;
  for (; sent < settings.count; ++sent) {
    Datagram datagram = corruption.next(sent >= honest);
    const bool multicast = (ntohl(datagram.destination.sin_addr.s_addr) >> 28) == 14;
    if (!multicast) {
      datagram.destination.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      datagram.destination.sin_port = htons(ports[corruption.below(ports.size())]);
    }
    refused += sender.send(datagram) ? 0 : 1;
    if (sent % std::max(1, settings.count / 10) == 0 || sent == settings.count - 1) {
      const std::chrono::duration<double> passed = Clock::now() - begun;
      std::printf("%10d %9.1f %14.1f %8zu %12zu %10lu\n", sent + 1, passed.count(), resident_mb(service),
                  poses.path().size(), lines_in(log), static_cast<unsigned long>(drops_of(service)));
      std::fflush(stdout);
      if (resident_mb(service) == 0.0) break;
    }
    std::this_thread::sleep_until(begun + std::chrono::duration<double>((sent + 1) / settings.rate));
  }
  kill(player, SIGINT);
  system::exit_status_of(player);
  std::this_thread::sleep_for(15s);  // participants that never were have gone
  std::printf("15 s later: resident %.1f MB, %zu lines of log\n", resident_mb(service), lines_in(log));
  kill(service, SIGTERM);
  const int status = system::exit_status_of(service);
  const auto truth = common::read_ground_truth(kFlat);
  const auto accuracy = truth ? common::evaluate_trajectory(poses.path(), *truth, {}) : tl::unexpected(truth.error());
  std::printf("sent %d, of which %zu the kernel refused; serve ended with %d\n", sent, refused, status);
  if (accuracy) {
    std::printf("poses: ATE %.3f m rmse, %.3f m at most\n", accuracy->ate_rmse_m, accuracy->ate_max_m);
  } else {
    std::printf("poses cannot be held against the truth: %s\n", accuracy.error().message.c_str());
  }
  std::ifstream said(log);
  std::printf("what it said:\n%s", std::string(std::istreambuf_iterator<char>(said), {}).c_str());
  fs::remove_all(folder);
  return status;
}
