// SPDX-License-Identifier: BSD-3-Clause
// What grows how: processor time and memory of mapping against particles, beams and the size of the building, of saving
// and loading a map as large as MIT's Killian Court, and of localisation. Buildings and drives are made up
// (office.hpp). Markdown tables, in the order below.
//
//     benchmark_laser_scaling [particles] [beams] [buildings] [saving] [localization]     all without a name
//
// Times are of one thread's processor time; memory is what the kernel counts as resident, beyond what was there before.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "laser_slam/laser_localization.hpp"
#include "laser_slam/laser_slam.hpp"
#include "office.hpp"
#include "process_meter.hpp"
#include "service/map_bundle.hpp"

namespace slamfuse {
namespace {

namespace fs = std::filesystem;
using common::Pose2;

constexpr double kMb = 1e6;
constexpr double kStep = 0.3;  // [m] of driving between two filter updates: just more than update_distance
constexpr common::Nanoseconds kPeriod = common::kNanosecondsPerSecond / 2;
constexpr int kBeams = 180;
constexpr int kParticles = 30;

struct Building {
  const char* name;
  OfficePlan plan;
};
const Building kFlat{"flat", {20.0, 15.0, 2, 2}};
const Building kFourFlats{"4 x flat", {40.0, 30.0, 3, 3}};
const Building kKillian{"as Killian Court", {250.0, 215.0, 4, 4}};

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

template <class T>
T value_or_exit(common::Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", result.error().message);
  std::exit(1);
}

/// A robot on its drive: gives the messages of one pose after the other. Its odometry errs by 1 % and 1 mrad a step.
class Robot {
 public:
  Robot(const OfficePlan& plan, int beams, double step)
      : office_(plan), laser_(office_laser(beams)), poses_(office_.drive(step)), noise_(5, 5) {}

  const common::LaserCalibration& laser() const { return laser_; }
  std::size_t poses() const { return poses_.size(); }
  void start_at(std::size_t pose) { next_ = pose; }

  /// Moves on to the next pose, or looks again from the same one.
  common::WheelOdometry move() {
    const Pose2 increment = poses_[next_ > 0 ? next_ - 1 : 0].inverse() * poses_[next_];
    const double error = 0.001 * noise_.normal();
    odometry_ = odometry_ * Pose2{increment.x * (1.0 + 0.01 * noise_.normal()), increment.y, increment.theta + error};
    stamp_ += kPeriod;
    here_ = poses_[next_++];
    return {stamp_, "odom0", odometry_, 0.0, 0.0};
  }
  common::WheelOdometry stand() {
    stamp_ += kPeriod;
    return {stamp_, "odom0", odometry_, 0.0, 0.0};
  }
  common::LaserScan scan() { return office_scan(office_, laser_, stamp_, here_, noise_); }

 private:
  Office office_;
  common::LaserCalibration laser_;
  std::vector<Pose2> poses_;
  laser_slam::RandomStream noise_;
  std::size_t next_ = 0;
  common::Nanoseconds stamp_ = 0;
  Pose2 here_;
  Pose2 odometry_;
};

laser_slam::LaserSlamOptions options_with(int particles) {
  laser_slam::LaserSlamOptions options;
  options.particles = particles;
  options.matcher.max_beams = 2000;
  return options;
}

std::unique_ptr<laser_slam::LaserSlam> mapper(int particles, const common::LaserCalibration& laser) {
  return value_or_exit(laser_slam::LaserSlam::create(options_with(particles), "laser0", laser, 1, 1));
}

/// Processor time of one scan [ms].
double process(common::SlamModule& module, const common::LaserScan& scan) {
  const double began = process_cpu_seconds();
  const common::ProcessResult result = module.process(scan);
  const double took = process_cpu_seconds() - began;
  if (result.rejected) fmt::print(stderr, "{}\n", *result.rejected);
  return 1e3 * took;
}

struct Mapping {
  std::vector<double> scan_ms;    // only followed
  std::vector<double> update_ms;  // with an update of the filter and the maps
  WorkCost cost;
  std::unique_ptr<laser_slam::LaserSlam> slam;
};

/// Drives for at most so many poses; at each the robot looks twice, and only the first scan updates the filter.
Mapping map_building(const Building& building, int particles, int beams, std::size_t most) {
  Robot robot(building.plan, beams, kStep);
  Mapping mapping;
  mapping.cost = measure([&] {
    mapping.slam = mapper(particles, robot.laser());
    for (std::size_t i = 0; i < std::min(most, robot.poses()); ++i) {
      mapping.slam->process(robot.move());
      const double update = process(*mapping.slam, robot.scan());
      if (i > 0) mapping.update_ms.push_back(update);
      mapping.slam->process(robot.stand());
      mapping.scan_ms.push_back(process(*mapping.slam, robot.scan()));
    }
  });
  return mapping;
}

/// The map of a whole building, made once with the usual number of particles.
const laser_slam::LocalizationMap& map_of(const Building& building, const Mapping* made = nullptr) {
  static std::map<std::string, laser_slam::LocalizationMap> maps;
  const auto known = maps.find(building.name);
  if (known != maps.end()) return known->second;
  if (made == nullptr) {
    const Mapping mapping = map_building(building, kParticles, kBeams, SIZE_MAX);
    return map_of(building, &mapping);
  }
  const laser_slam::LocalizationMap map{building.name, made->slam->grid(), value_or_exit(made->slam->serialize())};
  return maps.emplace(building.name, map).first->second;
}

std::string mapping_cells(const Mapping& mapping) {
  return fmt::format("{:.2f} | {:.1f} | {:.1f} | {:.0f}", quantile(mapping.scan_ms, 0.5),
                     quantile(mapping.update_ms, 0.5), quantile(mapping.update_ms, 0.95),
                     mapping.cost.peak_bytes / kMb);
}

constexpr const char* kMappingHead = "a scan, median [ms] | an update, median [ms] | p95 [ms] | peak memory [MB]";

void against_particles() {
  fmt::print("\nMapping, {} beams, {}:\n\n| particles | {} |\n|---|---|---|---|---|\n", kBeams, kFlat.name,
             kMappingHead);
  for (const int particles : {1, 10, 30, 100, 300}) {
    fmt::print("| {} | {} |\n", particles, mapping_cells(map_building(kFlat, particles, kBeams, 200)));
    std::fflush(stdout);
  }
}

void against_beams() {
  fmt::print("\nMapping, {} particles, {}, every beam matched:\n\n| beams | {} |\n|---|---|---|---|---|\n", kParticles,
             kFlat.name, kMappingHead);
  for (const int beams : {45, 180, 684, 2000}) {
    fmt::print("| {} | {} |\n", beams, mapping_cells(map_building(kFlat, kParticles, beams, 200)));
    std::fflush(stdout);
  }
}

void against_buildings() {
  fmt::print(
      "\nMapping, {} beams:\n\n| building | corridors [m] | driven [m] | particles | {} |\n"
      "|---|---|---|---|---|---|---|---|\n",
      kBeams, kMappingHead);
  for (const Building& building : {kFlat, kFourFlats, kKillian}) {
    for (const int particles : {1, kParticles}) {
      const Mapping mapping = map_building(building, particles, kBeams, SIZE_MAX);
      double driven = 0.0;
      const auto path = mapping.slam->final_trajectory();
      for (std::size_t i = 1; i < path.size(); ++i) {
        driven += std::hypot(path[i].pose.x - path[i - 1].pose.x, path[i].pose.y - path[i - 1].pose.y);
      }
      fmt::print("| {} | {:.0f} | {:.0f} | {} | {} |\n", building.name, building.plan.corridor_length(), driven,
                 particles, mapping_cells(mapping));
      std::fflush(stdout);
      if (particles == kParticles) map_of(building, &mapping);
    }
  }
}

double free_area(const common::OccupancyGrid& grid) {
  const auto free =
      std::count_if(grid.cells.begin(), grid.cells.end(), [](int cell) { return cell >= 0 && cell <= 25; });
  return static_cast<double>(free) * grid.resolution * grid.resolution;
}

void print_work(const std::string& what, const WorkCost& cost, double map_bytes) {
  fmt::print("| {} | {:.2f} | {:.1f} | {:.2f} |\n", what, cost.cpu_seconds, cost.peak_bytes / kMb,
             cost.peak_bytes / map_bytes);
}

void check(const common::Result<void>& done) {
  if (done) return;
  fmt::print(stderr, "{}\n", done.error().message);
  std::exit(1);
}

/// Saves a map of each building and loads it again.
void saving() {
  for (const Building& building : {kFlat, kKillian}) {
    const laser_slam::LocalizationMap& map = map_of(building);
    Robot robot(building.plan, kBeams, kStep);
    auto slam = mapper(1, robot.laser());
    const WorkCost restoring = measure([&] { check(slam->restore(map.laser_state)); });
    const double map_bytes = restoring.kept_bytes;
    process(*slam, robot.scan());

    common::OccupancyGrid grid;
    std::string state;
    const WorkCost exporting = measure([&] { grid = slam->grid(); });
    const WorkCost serializing = measure([&] { state = value_or_exit(slam->serialize()); });
    service::MapBundle bundle;
    bundle.grid = &grid;
    bundle.laser_state = state;
    const fs::path folder = fs::temp_directory_path() / "slamfuse_benchmark_map";
    const WorkCost writing = measure([&] { check(service::write_map_bundle(bundle, folder)); });
    service::LoadedMapBundle loaded;
    const WorkCost reading = measure([&] { loaded = value_or_exit(service::read_map_bundle(folder)); });
    fmt::print(
        "\nSaving and loading, {}: {:.0f} m of corridors, {:.0f} m2 free, grid {} x {} cells; the map takes {:.1f} MB "
        "in "
        "memory, `laser_state.bin` {:.2f} MB:\n\n| step | CPU [s] | peak memory beyond what was there [MB] | times the "
        "map |\n|---|---|---|---|\n",
        building.name, building.plan.corridor_length(), free_area(grid), grid.width, grid.height, map_bytes / kMb,
        static_cast<double>(state.size()) / kMb);
    print_work("occupancy grid from the map", exporting, map_bytes);
    print_work("state from the map", serializing, map_bytes);
    print_work("bundle written", writing, map_bytes);
    print_work("bundle read", reading, map_bytes);
    print_work("map restored from the state", restoring, map_bytes);
    std::fflush(stdout);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
}

/// Localises from the middle of the drive on, 20 m far.
void localize(const Building& building, const laser_slam::LocalizationMap& map, int particles) {
  constexpr double kShortStep = 0.15;
  laser_slam::LaserSlamOptions options = options_with(kParticles);
  options.localization.filter.min_particles = particles;
  options.localization.filter.max_particles = std::max(particles, options.localization.filter.max_particles);
  Robot robot(building.plan, kBeams, kShortStep);
  robot.start_at(robot.poses() / 2);
  std::unique_ptr<laser_slam::LaserLocalization> module;
  double search_ms = 0.0;
  std::vector<double> update_ms;
  double tracking = 0.0;
  const WorkCost cost = measure([&] {
    module = value_or_exit(laser_slam::LaserLocalization::create(options, "laser0", robot.laser(), map, 1));
    module->process(robot.move());
    search_ms = process(*module, robot.scan());
    for (int i = 0; i < 130; ++i) {
      module->process(robot.move());
      const common::LaserScan scan = robot.scan();
      const double began = process_cpu_seconds();
      const common::ProcessResult result = module->process(scan);
      const double took = process_cpu_seconds() - began;
      if (!result.estimate || result.estimate->state != common::TrackingState::kTracking) continue;
      update_ms.push_back(1e3 * took);
      tracking += 1.0;
    }
  });
  fmt::print("| {} | {:.0f} | {:.0f} x {:.0f} | {} | {:.0f} | {:.2f} | {:.2f} | {:.0f} | {:.0f} |\n", building.name,
             free_area(map.grid), map.grid.width * map.grid.resolution, map.grid.height * map.grid.resolution,
             particles, search_ms, quantile(update_ms, 0.5), quantile(update_ms, 0.95), tracking,
             cost.peak_bytes / kMb);
  std::fflush(stdout);
}

void localization() {
  fmt::print(
      "\nLocalisation, {} beams:\n\n| building | free area [m2] | grid [m] | particles of a hypothesis at least | "
      "search "
      "of the whole map [ms] | an update while TRACKING, median [ms] | p95 [ms] | scans TRACKING of 130 | peak memory "
      "[MB] |\n|---|---|---|---|---|---|---|---|---|\n",
      kBeams);
  for (const int particles : {50, 200, 1000, 5000}) localize(kFlat, map_of(kFlat), particles);
  for (const Building& building : {kFourFlats, kKillian}) localize(building, map_of(building), 50);
}

struct Table {
  const char* name;
  void (*print)();
};
constexpr Table kTables[] = {{"particles", against_particles},
                             {"beams", against_beams},
                             {"buildings", against_buildings},
                             {"saving", saving},
                             {"localization", localization}};

int benchmark(const std::vector<std::string>& wanted) {
  for (const std::string& name : wanted) {
    if (std::none_of(std::begin(kTables), std::end(kTables), [&](const Table& table) { return name == table.name; })) {
      fmt::print(stderr, "no table '{}'; allowed are particles, beams, buildings, saving, localization\n", name);
      return 2;
    }
  }
  for (const Table& table : kTables) {
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), table.name) != wanted.end()) table.print();
  }
  return 0;
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) { return slamfuse::benchmark({argv + 1, argv + argc}); }
