// SPDX-License-Identifier: BSD-3-Clause
// How accurate and how fast the laser SLAM is: one row a recording and seed, as Markdown. Truth, where there is some,
// is found beside the recording: ground truth of an EuRoC folder, NAME.reference.txt and NAME.relations of
// NAME.clf.bz2.
//
//   benchmark_laser_accuracy [--seeds N] [--threads N] [--set laser.key=value]... [--pictures DIR] [--pixel M]
//                            [--fit-offset] [--topic SENSOR=TOPIC]... [--sweep-duration SENSOR=S]... RECORDING...

#include <ctime>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/angle.hpp"
#include "common/carmen_reference.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/relations.hpp"
#include "common/replay.hpp"
#include "common/trajectory_evaluation.hpp"
#include "common/tum.hpp"
#include "laser_slam/laser_slam.hpp"

namespace slamfuse {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  int seeds = 5;
  int first_seed = 1;
  int threads = 2;
  std::vector<std::string> settings;
  std::string pictures;
  double pixel = 0.05;
  std::vector<double> degenerate_within;
  bool fit_offset = false;
  std::vector<std::string> topics;           // SENSOR=TOPIC
  std::vector<std::string> sweep_durations;  // SENSOR=SECONDS
  std::vector<std::string> recordings;
};

/// A recording's laser and odometry messages in memory, and what is known of the truth.
struct Input {
  std::string name;
  std::string laser;
  common::LaserCalibration calibration;
  std::vector<common::SensorMessage> messages;
  common::Trajectory2 truth;      // of base_link
  common::Trajectory2 reference;  // of the laser, at equal stamps
  std::vector<common::PoseRelation> relations;
  bool fit_offset = false;
};

struct Run {
  common::Trajectory2 online;
  common::Trajectory2 final_path;
  common::OccupancyGrid grid;
  std::vector<common::Event> events;
  std::vector<common::PoseEstimate> estimates;
  double cpu_seconds = 0.0;
  double peak_mb = 0.0;
  int rejected = 0;
};

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void reset_peak_memory() { std::ofstream("/proc/self/clear_refs") << "5"; }

double memory_mb(const std::string& key) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(key)) return std::stod(line.substr(key.size() + 1)) / 1024.0;
  }
  return 0.0;
}

/// NAME.reference.txt for NAME.clf.bz2 and the like.
fs::path beside(const fs::path& recording, const std::string& ending) {
  const std::string file = recording.filename().string();
  return recording.parent_path() / (file.substr(0, file.find('.')) + ending);
}

/// "NAME=VALUE" texts as a map; a text without '=' names nothing.
std::map<std::string, std::string> by_name(const std::vector<std::string>& texts) {
  std::map<std::string, std::string> values;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    values[text.substr(0, equals)] = equals == std::string::npos ? "" : text.substr(equals + 1);
  }
  return values;
}

common::Result<Input> load(const fs::path& path, const Arguments& arguments) {
  common::RecordingOptions options;
  options.topics = by_name(arguments.topics);
  common::ReplayOptions replay_options;
  for (const auto& [sensor, seconds] : by_name(arguments.sweep_durations)) {
    replay_options.sweep_duration[sensor] = std::strtod(seconds.c_str(), nullptr);
  }
  auto opened = common::open_recording(path, options);
  if (!opened) return tl::unexpected(opened.error());
  auto recording = common::replay(std::move(*opened), replay_options);
  if (!recording) return tl::unexpected(recording.error());
  const common::RecordingInfo& info = (*recording)->info();
  if (info.calibration.lasers.empty()) return common::invalid_input(path.string() + ": no laser");
  Input input;
  input.name = path.filename().string();
  input.fit_offset = arguments.fit_offset;
  input.laser = info.calibration.lasers.begin()->first;
  input.calibration = info.calibration.lasers.begin()->second;
  while (true) {
    auto item = (*recording)->next();
    if (!item) return tl::unexpected(item.error());
    if (!*item) break;
    auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message && !std::holds_alternative<common::Image>(*message)) input.messages.push_back(std::move(*message));
  }
  if (auto truth = common::read_ground_truth(path, options)) input.truth = std::move(*truth);
  if (const fs::path file = beside(path, ".reference.txt"); fs::exists(file)) {
    auto reference = common::read_carmen_reference(file);
    if (!reference) return tl::unexpected(reference.error());
    input.reference = std::move(*reference);
  }
  if (const fs::path file = beside(path, ".relations"); fs::exists(file)) {
    auto relations = common::read_relations(file);
    if (!relations) return tl::unexpected(relations.error());
    input.relations = std::move(*relations);
  }
  return input;
}

common::Result<Run> run(const Input& input, const laser_slam::LaserSlamOptions& options, std::uint64_t seed,
                        int threads) {
  reset_peak_memory();
  const double memory_before = memory_mb("VmRSS:");
  const double began = cpu_seconds();
  auto slam = laser_slam::LaserSlam::create(options, input.laser, input.calibration, seed, threads);
  if (!slam) return tl::unexpected(slam.error());
  Run result;
  for (const common::SensorMessage& message : input.messages) {
    const common::ProcessResult processed = (*slam)->process(message);
    if (processed.rejected) ++result.rejected;
    if (!processed.estimate) continue;
    result.online.push_back({processed.estimate->stamp, processed.estimate->pose});
    for (const common::Event& event : processed.estimate->events) result.events.push_back(event);
    result.estimates.push_back(*processed.estimate);
  }
  (*slam)->refine();
  result.final_path = (*slam)->final_trajectory();
  result.cpu_seconds = cpu_seconds() - began;
  result.peak_mb = memory_mb("VmHWM:") - memory_before;
  result.grid = (*slam)->grid();
  return result;
}

/// Root mean square of the position errors [m]; nothing without truth.
std::optional<common::TrajectoryAccuracy> accuracy_of(const Input& input, const common::Trajectory2& path) {
  common::EvaluationOptions options;
  options.fit_offset = input.fit_offset;
  auto reference = &input.truth;
  common::Trajectory2 estimate = path;
  if (!input.reference.empty()) {
    options.max_reference_gap = 0;
    reference = &input.reference;
    estimate = common::sensor_trajectory(path, common::to_pose2(input.calibration.T_base_laser));
  }
  if (reference->empty()) return std::nullopt;
  auto accuracy = common::evaluate_trajectory(estimate, *reference, options);
  return accuracy ? std::optional(std::move(*accuracy)) : std::nullopt;
}

std::string ate(const std::optional<common::TrajectoryAccuracy>& accuracy) {
  return accuracy ? fmt::format("{:.4f}", accuracy->ate_rmse_m) : "-";
}

/// The errors of one path over the seeds.
class Spread {
 public:
  void add(const std::optional<common::TrajectoryAccuracy>& accuracy) {
    if (accuracy) errors_.push_back(accuracy->ate_rmse_m);
  }
  /// "median (worst)".
  std::string text() {
    if (errors_.empty()) return "-";
    std::sort(errors_.begin(), errors_.end());
    const std::size_t half = errors_.size() / 2;
    const double median = errors_.size() % 2 == 1 ? errors_[half] : 0.5 * (errors_[half - 1] + errors_[half]);
    return fmt::format("{:.4f} ({:.4f})", median, errors_.back());
  }

 private:
  std::vector<double> errors_;
};

/// Mean share of a scan's beams that agree with the map: tells which of two settings fits better where there is no
/// truth.
double mean_agreement(const Run& run) {
  double sum = 0.0;
  int count = 0;
  for (const common::PoseEstimate& estimate : run.estimates) {
    if (!estimate.health.scan_likelihood) continue;
    sum += *estimate.health.scan_likelihood;
    ++count;
  }
  return count > 0 ? sum / count : 0.0;
}

std::string relation_errors(const Input& input, const common::Trajectory2& path) {
  if (input.relations.empty()) return "-";
  const auto accuracy = common::evaluate_relations(path, input.relations);
  if (!accuracy) return "-";
  return fmt::format("{:.4f} / {:.3f} / {:.4f}", accuracy->all.translation_m.mean, accuracy->all.rotation_deg.mean,
                     accuracy->distant.translation_m.mean);
}

/// Share of the scans [%] said to leave a direction open, of those whose true x [m] is within these bounds.
double degenerate_percent(const Input& input, const Run& run, const std::vector<double>& x_bounds) {
  int flagged = 0;
  int counted = 0;
  for (const common::PoseEstimate& estimate : run.estimates) {
    if (!x_bounds.empty()) {
      const auto truth = common::pose_at(input.truth, estimate.stamp, common::kNanosecondsPerSecond / 10);
      if (!truth || truth->x < x_bounds[0] || truth->x > x_bounds[1]) continue;
    }
    ++counted;
    if (estimate.health.degenerate_direction) ++flagged;
  }
  return 100.0 * flagged / std::max(1, counted);
}

/// Mean normalised squared error of the online poses per degree of freedom: 1 where the covariances are right, more
/// where they promise too much. The frames are aligned first, so a common error does not count.
std::string consistency(const Input& input, const Run& run) {
  if (input.truth.empty() || !input.reference.empty()) return "-";
  const auto accuracy = accuracy_of(input, run.online);
  if (!accuracy) return "-";
  const common::Pose2 T_body_base = accuracy->T_base_body.inverse();
  double sum = 0.0;
  int count = 0;
  for (const common::PoseEstimate& estimate : run.estimates) {
    const auto truth =
        common::pose_at(input.truth, estimate.stamp + accuracy->clock_offset, common::kNanosecondsPerSecond / 10);
    if (!truth) continue;
    const common::Pose2 expected = accuracy->T_reference_estimate.inverse() * *truth * T_body_base;
    const Eigen::Vector3d error(estimate.pose.x - expected.x, estimate.pose.y - expected.y,
                                common::angle_difference(estimate.pose.theta, expected.theta));
    sum += error.dot(estimate.covariance.inverse() * error);
    ++count;
  }
  return count > 0 ? fmt::format("{:.2f}", sum / (3.0 * count)) : "-";
}

/// Walls black, free white, unknown gray, the final path in red; one pixel is `pixel` metres. Few shades make small
/// files.
void draw(const Run& run, const fs::path& file, double pixel) {
  constexpr double kUnknownGray = 205.0;
  constexpr double kShade = 51.0;
  const common::OccupancyGrid& grid = run.grid;
  cv::Mat gray(grid.height, grid.width, CV_8U, cv::Scalar(kUnknownGray));
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      const int value = grid.at(column, row);
      if (value >= 0)
        gray.at<std::uint8_t>(grid.height - 1 - row, column) = static_cast<std::uint8_t>(255 - 255 * value / 100);
    }
  }
  const double scale = grid.resolution / pixel;
  cv::resize(gray, gray, {}, scale, scale, cv::INTER_AREA);
  gray.forEach<std::uint8_t>(
      [](std::uint8_t& value, const int*) { value = static_cast<std::uint8_t>(kShade * std::round(value / kShade)); });
  cv::Mat picture;
  cv::cvtColor(gray, picture, cv::COLOR_GRAY2BGR);
  for (const common::StampedPose2& pose : run.final_path) {
    const Eigen::Vector2d cell = (pose.pose.translation() - grid.origin) / pixel;
    const cv::Point at(static_cast<int>(cell.x()), picture.rows - 1 - static_cast<int>(cell.y()));
    if (at.inside(cv::Rect(0, 0, picture.cols, picture.rows))) picture.at<cv::Vec3b>(at) = {0, 0, 255};
  }
  cv::imwrite(file.string(), picture, {cv::IMWRITE_PNG_COMPRESSION, 9});
}

int benchmark(const Arguments& arguments) {
  laser_slam::LaserSlamOptions options;
  const auto describe = [&](common::OptionVisitor& visit) { visit.nested("laser", options, "Laser SLAM."); };
  for (const std::string& setting : arguments.settings) {
    if (auto set = common::set_option(setting, describe); !set) {
      fmt::print(stderr, "{}\n", set.error().message);
      return 2;
    }
  }
  fmt::print(
      "| recording | seed | ATE online m | ATE final m | relations online m / deg / distant m | relations final | "
      "loops | "
      "other events | degenerate % | agreement | NEES/3 | CPU s | peak MB |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string& path : arguments.recordings) {
    const auto input = load(path, arguments);
    if (!input) {
      fmt::print(stderr, "{}\n", input.error().message);
      return 3;
    }
    Spread online_errors;
    Spread final_errors;
    for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed) {
      const auto result = run(*input, options, static_cast<std::uint64_t>(seed), arguments.threads);
      if (!result) {
        fmt::print(stderr, "{}\n", result.error().message);
        return 3;
      }
      const auto loops = std::count_if(result->events.begin(), result->events.end(),
                                       [](const common::Event& event) { return event.kind == "loop_closed"; });
      const auto online = accuracy_of(*input, result->online);
      const auto final_path = accuracy_of(*input, result->final_path);
      online_errors.add(online);
      final_errors.add(final_path);
      fmt::print("| {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} | {:.4f} | {} | {:.1f} | {:.0f} |\n", input->name,
                 seed, ate(online), ate(final_path), relation_errors(*input, result->online),
                 relation_errors(*input, result->final_path), loops,
                 result->events.size() - static_cast<std::size_t>(loops),
                 degenerate_percent(*input, *result, arguments.degenerate_within), mean_agreement(*result),
                 consistency(*input, *result), result->cpu_seconds, result->peak_mb);
      std::fflush(stdout);
      if (input->fit_offset && final_path) {
        fmt::print(stderr, "{} seed {}: tracked body at ({:.4f}, {:.4f}) m, {:.2f} deg; clock {:+.4f} s\n", input->name,
                   seed, final_path->T_base_body.x, final_path->T_base_body.y,
                   common::to_degrees(final_path->T_base_body.theta), common::to_seconds(final_path->clock_offset));
      }
      if (arguments.pictures.empty()) continue;
      const fs::path stem = fs::path(arguments.pictures) / fmt::format("{}-{}", input->name, seed);
      draw(*result, stem.string() + ".png", arguments.pixel);
      if (auto written = common::write_tum(stem.string() + ".final.tum", result->final_path); !written) {
        fmt::print(stderr, "{}\n", written.error().message);
      }
      for (const common::Event& event : result->events) {
        fmt::print(stderr, "{} {} {}\n", common::format_seconds(event.stamp), event.kind, event.detail);
      }
    }
    fmt::print("| {} | median (worst) | {} | {} | | | | | | | | | |\n", input->name, online_errors.text(),
               final_errors.text());
  }
  return 0;
}

}  // namespace
}  // namespace slamfuse

int main(int argc, char** argv) {
  slamfuse::Arguments arguments;
  CLI::App app("Accuracy and cost of the laser SLAM");
  app.add_option("--seeds", arguments.seeds, "how many seeds");
  app.add_option("--first-seed", arguments.first_seed, "the first of them");
  app.add_option("--threads", arguments.threads, "worker threads");
  app.add_option("--set", arguments.settings, "laser.key=value")->allow_extra_args(false);
  app.add_option("--pictures", arguments.pictures, "folder for maps and paths");
  app.add_option("--degenerate-within", arguments.degenerate_within,
                 "count the degenerate scans of true x [m] from, to")
      ->expected(2);
  app.add_option("--pixel", arguments.pixel, "side of a picture's pixel [m]");
  app.add_flag("--fit-offset", arguments.fit_offset,
               "the truth is of another body by another clock: fit both constant offsets");
  app.add_option("--topic", arguments.topics, "SENSOR=TOPIC, of a ROS bag")->allow_extra_args(false);
  app.add_option("--sweep-duration", arguments.sweep_durations, "SENSOR=SECONDS, negative: last beam first")
      ->allow_extra_args(false);
  app.add_option("recordings", arguments.recordings, "recordings")->required();
  CLI11_PARSE(app, argc, argv);
  return slamfuse::benchmark(arguments);
}
