// SPDX-License-Identifier: BSD-3-Clause
// Maps one recording, or the first part of it, with the visual SLAM and goes on in that map: as it is (slam),
// localising in the saved map (localize) or continuing it (continue). Prints accuracy, cost, and what happened after
// each time the robot was carried.
//
//     benchmark_visual_localization MAPPED CAMERAS MAP_TO LATER FROM slam|localize|continue [visual.key=value ...]
//
// MAPPED is mapped to MAP_TO [s] (0: to its end), then LATER is played from FROM [s]. Poses are compared with the truth
// by the alignment fitted to the mapping.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "common/angle.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "visual_slam/camera.hpp"
#include "visual_slam/visual_slam.hpp"

namespace {

using namespace slamfuse;
using common::Nanoseconds;

constexpr double kWrongPosition = 0.5;                         // [m]
constexpr double kWrongHeading = 10.0;                         // [deg]
constexpr int kMappedWall = 20;                                // so many landmarks in view are a mapped wall
constexpr double kSimilarAngle = 0.5;                          // [rad] from where it was seen in mapping...
constexpr double kSimilarScale = 1.6;                          // ...and factor of the distance
constexpr Nanoseconds kCarry = common::kNanosecondsPerSecond;  // a longer hole in the truth is a carry

/// Everything the estimator said.
struct Run {
  std::vector<common::PoseEstimate> estimates;
  std::vector<common::Event> events;
  double cpu_seconds = 0.0;
  Nanoseconds start = 0;
};

[[noreturn]] void fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(EXIT_FAILURE);
}

template <class T>
T value_or_fail(common::Result<T> result) {
  if (!result) fail(result.error().message);
  return std::move(*result);
}

/// Plays a stretch of a recording [s after its start; to <= 0: to the end].
Run play(common::SlamModule& module, const std::string& path, double from, double to) {
  auto recording = value_or_fail(common::open_recording(path));
  Run run;
  run.start = recording->info().first_stamp;
  while (true) {
    auto item = value_or_fail(recording->next());
    if (!item) break;
    const auto* message = std::get_if<common::SensorMessage>(&*item);
    if (message == nullptr || !module.wants(*message)) continue;
    const double at = common::to_seconds(common::stamp_of(*message) - run.start);
    if (to > 0.0 && at > to) break;
    if (at < from) continue;
    const std::clock_t cpu = std::clock();
    const common::ProcessResult result = module.process(*message);
    run.cpu_seconds += static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    if (!result.estimate) continue;
    run.events.insert(run.events.end(), result.estimate->events.begin(), result.estimate->events.end());
    run.estimates.push_back(*result.estimate);
  }
  return run;
}

common::Trajectory2 path_of(const Run& run, common::TrackingState at_worst) {
  common::Trajectory2 path;
  for (const common::PoseEstimate& one : run.estimates) {
    if (one.state <= at_worst) path.push_back({one.stamp, one.pose});
  }
  return path;
}

/// How many landmarks of the map a camera has in view from a true pose, seen in mapping from a similar place.
int landmarks_in_view(const std::vector<common::Landmark>& map, const visual_slam::Camera& camera,
                      const common::Pose2& pose) {
  const Eigen::Rotation2Dd turn(pose.theta);
  const Eigen::Vector2d level = pose.translation() + turn * camera.t_base_camera.head<2>();
  const Eigen::Vector3d centre(level.x(), level.y(), camera.t_base_camera.z());
  Eigen::Matrix3d R_map_base = Eigen::Matrix3d::Identity();
  R_map_base.topLeftCorner<2, 2>() = turn.toRotationMatrix();
  int count = 0;
  for (const common::Landmark& landmark : map) {
    const Eigen::Vector3d view = landmark.position - centre;
    const auto pixel = camera.calibration.project(camera.R_base_camera.transpose() * R_map_base.transpose() * view);
    if (!pixel || !camera.sees(*pixel, 0.0)) continue;
    count += std::any_of(landmark.views.begin(), landmark.views.end(), [&view](const common::LandmarkView& seen) {
      const double scale = seen.direction.norm() / view.norm();
      return std::max(scale, 1.0 / scale) < kSimilarScale &&
             std::acos(std::clamp(seen.direction.dot(view) / seen.direction.norm() / view.norm(), -1.0, 1.0)) <
                 kSimilarAngle;
    });
  }
  return count;
}

void print_accuracy(const char* name, const common::TrajectoryAccuracy& accuracy, const Run& run) {
  std::printf(
      "%-14s ATE rmse %.4f m  max %.4f m  heading rmse %.3f deg  coverage %.4f  %.2f ms of the processor an image\n",
      name, accuracy.ate_rmse_m, accuracy.ate_max_m, accuracy.heading_rmse_deg, accuracy.coverage,
      1e3 * run.cpu_seconds / static_cast<double>(std::max<std::size_t>(1, run.estimates.size())));
}

/// The stamp of the first estimate at or after `from` for which `is` holds.
template <class Condition>
std::optional<Nanoseconds> first(const Run& run, Nanoseconds from, Condition is) {
  for (const common::PoseEstimate& one : run.estimates) {
    if (one.stamp >= from && is(one)) return one.stamp;
  }
  return std::nullopt;
}

std::string seconds_after(const std::optional<Nanoseconds>& stamp, Nanoseconds since) {
  if (!stamp) return "never";
  char text[32];
  std::snprintf(text, sizeof text, "%.2f s", common::to_seconds(*stamp - since));
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) {
    fail(
        "usage: benchmark_visual_localization MAPPED CAMERAS MAP_TO LATER FROM slam|localize|continue "
        "[visual.key=value ...]");
  }
  const std::string mapped = argv[1], later = argv[4], mode = argv[6];
  visual_slam::VisualSlamOptions options;
  for (int i = 7; i < argc; ++i) {
    const auto set = common::set_option(
        argv[i], [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) fail(set.error().message);
  }
  const auto calibrated = value_or_fail(common::open_recording(mapped))->info().calibration.cameras;
  std::map<std::string, common::CameraCalibration> cameras;
  std::istringstream names(argv[2]);
  for (std::string name; std::getline(names, name, ',');) {
    if (!calibrated.contains(name)) fail("the recording has no camera " + name);
    cameras.emplace(name, calibrated.at(name));
  }
  auto slam = value_or_fail(visual_slam::VisualSlam::create(options, cameras, 1, 1));
  const Run mapping = play(*slam, mapped, 0.0, std::atof(argv[3]));
  const auto truth = value_or_fail(common::read_ground_truth(mapped));
  const auto online =
      value_or_fail(common::evaluate_trajectory(path_of(mapping, common::TrackingState::kUncertain), truth));
  const auto fitted = value_or_fail(common::evaluate_trajectory(slam->final_trajectory(), truth));
  const common::Similarity2 T_truth_map = fitted.T_reference_estimate;
  print_accuracy("mapping", online, mapping);
  print_accuracy("mapping, final", fitted, mapping);
  const std::vector<common::Landmark> map = slam->landmarks();
  std::printf("%zu landmarks\n", map.size());

  if (mode != "slam") {
    slam = value_or_fail(visual_slam::VisualSlam::create(options, cameras, 1, 1));
    const auto use = mode == "localize" ? visual_slam::MapUse::kLocalise : visual_slam::MapUse::kContinue;
    if (const auto loaded = slam->load(map, use); !loaded) fail(loaded.error().message);
  }
  const Run run = play(*slam, later, std::atof(argv[5]), 0.0);
  const auto later_truth = value_or_fail(common::read_ground_truth(later));
  const common::EvaluationOptions in_map{.align = common::EvaluationAlignment::kAs,
                                         .T_reference_estimate = T_truth_map};
  const auto tracking =
      common::evaluate_trajectory(path_of(run, common::TrackingState::kTracking), later_truth, in_map);
  if (tracking) print_accuracy("TRACKING", *tracking, run);
  const auto known = common::evaluate_trajectory(path_of(run, common::TrackingState::kUncertain), later_truth, in_map);
  if (known) print_accuracy("and UNCERTAIN", *known, run);
  const auto final_path = common::evaluate_trajectory(slam->final_trajectory(), later_truth, in_map);
  if (final_path) print_accuracy("final, all", *final_path, run);
  const auto wrong = [](const common::PoseError& error) {
    return error.position > kWrongPosition || std::abs(common::to_degrees(error.heading)) > kWrongHeading;
  };
  if (tracking) {
    std::printf("%zu images, TRACKING at %zu, wrong at %zu of them by more than %.1f m or %.0f deg\n",
                run.estimates.size(), tracking->errors.size(),
                static_cast<std::size_t>(std::count_if(tracking->errors.begin(), tracking->errors.end(), wrong)),
                kWrongPosition, kWrongHeading);
  }

  // After the start and after each carry.
  std::vector<Nanoseconds> begins;
  if (!run.estimates.empty()) begins.push_back(run.estimates.front().stamp);
  for (std::size_t i = 1; i < later_truth.size(); ++i) {
    if (later_truth[i].stamp - later_truth[i - 1].stamp < kCarry || later_truth[i].stamp < begins.front()) continue;
    if (const auto image = first(run, later_truth[i].stamp, [](const auto&) { return true; })) begins.push_back(*image);
  }
  const auto in_view = [&](const common::PoseEstimate& one) {
    const auto pose = common::pose_at(later_truth, one.stamp, common::kNanosecondsPerSecond / 10);
    if (!pose) return false;
    return std::any_of(cameras.begin(), cameras.end(), [&](const auto& camera) {
      return landmarks_in_view(map, visual_slam::Camera(camera.first, camera.second), T_truth_map.inverse() * *pose) >=
             kMappedWall;
    });
  };
  for (const Nanoseconds begin : begins) {
    const auto lost = first(run, begin, [](const auto& one) { return one.state == common::TrackingState::kLost; });
    const auto wall = first(run, begin, in_view);
    const auto found =
        first(run, lost.value_or(begin), [](const auto& one) { return one.state == common::TrackingState::kTracking; });
    std::printf("first image at %.2f s: LOST after %s, mapped walls in view after %s, TRACKING after %s\n",
                common::to_seconds(begin - run.start), seconds_after(lost, begin).c_str(),
                seconds_after(wall, begin).c_str(), seconds_after(found, begin).c_str());
  }
  for (const common::Event& event : run.events) {
    std::printf("%.2f s %s: %s\n", common::to_seconds(event.stamp - run.start), event.kind.c_str(),
                event.detail.c_str());
  }
  return EXIT_SUCCESS;
}
