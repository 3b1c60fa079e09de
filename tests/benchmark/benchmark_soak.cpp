// SPDX-License-Identifier: BSD-3-Clause
// A long run of the service: `slamfuse play` in a loop into `slamfuse serve`, its resident memory and the latency of
// its poses over time.
//
//     benchmark_soak [--minutes M] [--rate X] [--recording PATH] [--modules laser|visual|laser,visual]
//                    [-- further arguments of serve]
//
// Prints a row for each tenth of the time and the trend of memory over the last nine tenths. The map is made by `run`
// with the same modules first, and localised in: a robot that is carried to the start again and again makes no map.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "idl/reader.hpp"
#include "service/ros_conversion.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"

namespace {

namespace fs = std::filesystem;
using namespace slamfuse;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

struct Settings {
  double minutes = 10.0;
  std::string rate = "5";
  std::string recording = SLAMFUSE_DATA_DIR "/flat";
  std::string modules = "laser";
  std::vector<std::string> serve;
};

/// Empty when a word is not known.
std::optional<Settings> settings_of(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") {
      settings.serve.assign(argv + i + 1, argv + argc);
      break;
    }
    if (i + 1 == argc) return std::nullopt;
    const std::string value = argv[++i];
    if (word == "--minutes") {
      settings.minutes = std::atof(value.c_str());
    } else if (word == "--rate") {
      settings.rate = value;
    } else if (word == "--recording") {
      settings.recording = value;
    } else if (word == "--modules") {
      settings.modules = value;
    } else {
      return std::nullopt;
    }
  }
  return settings;
}

/// Resident memory of a process [10^6 bytes].
double resident_mb(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/statm");
  double pages = 0.0;
  double resident = 0.0;
  file >> pages >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

/// From a scan's arrival here to that of the pose with its stamp.
class Latency {
 public:
  explicit Latency(const idl::Participant& participant)
      : scans_(listen<idl::LaserScan>(participant, "scan", [this](common::Nanoseconds stamp) { scan(stamp); })),
        poses_(listen<idl::PoseWithCovarianceStamped>(participant, "slamfuse/pose",
                                                      [this](common::Nanoseconds stamp) { pose(stamp); })) {}

  /// Those since the last call, sorted [ms].
  std::vector<double> take() {
    const std::lock_guard lock(mutex_);
    auto latencies = std::exchange(latencies_, {});
    std::ranges::sort(latencies);
    return latencies;
  }

 private:
  template <class T, class Use>
  static std::jthread listen(const idl::Participant& participant, const std::string& topic, const Use& use) {
    return std::jthread([&participant, topic, use](const std::stop_token& done) {
      auto reader = idl::Reader<T>::create(participant, topic, idl::QosProfile::kTransformInput);
      while (reader && !done.stop_requested()) {
        const auto message = reader->take(50ms);
        if (message && *message) use(service::from_ros_time((**message)->header.stamp));
      }
    });
  }

  void scan(common::Nanoseconds stamp) {
    const std::lock_guard lock(mutex_);
    arrived_[stamp] = Clock::now();
    constexpr std::size_t kWaiting = 1000;
    if (arrived_.size() > kWaiting) arrived_.erase(arrived_.begin());
  }
  void pose(common::Nanoseconds stamp) {
    const std::lock_guard lock(mutex_);
    const auto found = arrived_.find(stamp);
    if (found == arrived_.end()) return;
    latencies_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - found->second).count());
    arrived_.erase(found);
  }

  std::mutex mutex_;
  std::map<common::Nanoseconds, Clock::time_point> arrived_;
  std::vector<double> latencies_;
  std::jthread scans_;
  std::jthread poses_;
};

/// Slope of a line through samples, per step.
double slope(const std::vector<double>& samples) {
  const auto n = static_cast<double>(samples.size());
  double sum_x = 0.0, sum_y = 0.0, sum_xx = 0.0, sum_xy = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto x = static_cast<double>(i);
    sum_x += x;
    sum_y += samples[i];
    sum_xx += x * x;
    sum_xy += x * samples[i];
  }
  return (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
}

}  // namespace

int main(int argc, char** argv) {
  const auto given = settings_of(argc, argv);
  if (!given) {
    std::fprintf(stderr, "see the head of benchmark_soak.cpp\n");
    return 2;
  }
  const Settings& settings = *given;
  const fs::path folder = fs::temp_directory_path() / ("slamfuse-soak-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const system::Network network;
  const auto participant = network.join();
  std::printf("making the map\n");
  if (system::exit_status_of(system::start(
          {SLAMFUSE_PROGRAM, "run", settings.recording, "-o", folder / "map", "--modules", settings.modules})) != 0)
    return 1;
  std::vector<std::string> serve{SLAMFUSE_PROGRAM, "serve",         "-o",    folder / "out",
                                 "--mode",         "localization",  "--map", folder / "map" / "map",
                                 "--modules",      settings.modules};
  serve.insert(serve.end(), settings.serve.begin(), settings.serve.end());
  const pid_t service = system::start(serve);
  const pid_t player = system::start(
      {SLAMFUSE_PROGRAM, "play", settings.recording, "--rate", settings.rate, "--times", "0", "--wait", "10"});

  std::vector<double> resident;
  {
    Latency latency(participant);
    constexpr int kRows = 10;
    std::printf("%8s %14s %10s %12s %10s\n", "minutes", "resident [MB]", "poses", "median [ms]", "p99 [ms]");
    for (int row = 1; row <= kRows; ++row) {
      const auto end = Clock::now() + std::chrono::duration<double>(settings.minutes * 60.0 / kRows);
      while (Clock::now() < end) {
        std::this_thread::sleep_for(1s);
        if (row > 1) resident.push_back(resident_mb(service));
      }
      const auto latencies = latency.take();
      const bool any = !latencies.empty();
      std::printf("%8.1f %14.1f %10zu %12.1f %10.1f\n", settings.minutes * row / kRows, resident_mb(service),
                  latencies.size(), any ? latencies[latencies.size() / 2] : 0.0,
                  any ? latencies[latencies.size() * 99 / 100] : 0.0);
      std::fflush(stdout);
    }
  }
  kill(player, SIGINT);
  system::exit_status_of(player);
  kill(service, SIGTERM);
  const int status = system::exit_status_of(service);
  if (resident.size() > 2) {
    const double per_second = slope(resident);
    std::printf("trend of resident memory after the first tenth: %+.2f MB an hour (%+.2f %% of %.1f MB)\n",
                3600.0 * per_second, 100.0 * per_second * static_cast<double>(resident.size()) / resident.front(),
                resident.front());
  }
  fs::remove_all(folder);
  return status;
}
