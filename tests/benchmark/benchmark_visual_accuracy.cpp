// SPDX-License-Identifier: BSD-3-Clause
// Runs the visual SLAM alone on a recording and prints accuracy, coverage and cost of an image. Without ground truth
// the path is held against a straight line, as for a camera moved along a rail.
//
//     benchmark_visual_accuracy RECORDING CAMERAS [THREADS] [mounting=DEG,METRES] [at=SECONDS] [visual.key=value ...]
//
// `at`, which may be given again and again, prints how far the estimate of that moment after the start is from the
// truth with the paths aligned at the first pose, in metres and percent of the way driven; the last moment is always
// printed. CAMERAS is a list such as cam0,cam1. `mounting` falsifies what is told of where the cameras are: each turned
// to the left by DEG about the vertical through its own centre, and moved forward by METRES.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "common/angle.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/trajectory.hpp"
#include "common/trajectory_evaluation.hpp"
#include "common/tum.hpp"
#include "visual_slam/visual_slam.hpp"

namespace {

using namespace slamfuse;

struct Run {
  common::Trajectory2 online;    // poses that were not LOST
  common::Trajectory2 odometry;  // at the stamps of the images
  std::vector<double> milliseconds;
  std::vector<common::Event> events;
  double cpu_seconds = 0.0;
  std::size_t rejected = 0;
};

void print_row(const char* name, const common::Trajectory2& estimate, const common::Trajectory2& truth,
               common::EvaluationAlignment align = common::EvaluationAlignment::kSe2) {
  const auto accuracy = common::evaluate_trajectory(estimate, truth, {.align = align, .T_reference_estimate = {}});
  if (!accuracy) {
    std::printf("%-10s %s\n", name, accuracy.error().message.c_str());
    return;
  }
  std::printf("%-10s ATE rmse %.4f m  max %.4f m  heading rmse %.3f deg  RPE %.3f %%  coverage %.4f\n", name,
              accuracy->ate_rmse_m, accuracy->ate_max_m, accuracy->heading_rmse_deg,
              accuracy->rpe_percent.value_or(0.0), accuracy->coverage);
}

/// How far a path is from the straight line that fits best, in percent of its length along the line.
void print_line_row(const char* name, const common::Trajectory2& path, std::size_t images) {
  if (path.size() < 2) return;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& [stamp, pose] : path) mean += pose.translation() / static_cast<double>(path.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto& [stamp, pose] : path) {
    scatter += (pose.translation() - mean) * (pose.translation() - mean).transpose() / static_cast<double>(path.size());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(scatter);
  double first = 0.0, last = 0.0;
  for (const auto& [stamp, pose] : path) {
    const double along = axes.eigenvectors().col(1).dot(pose.translation() - mean);
    first = std::min(first, along);
    last = std::max(last, along);
  }
  std::printf("%-10s %zu of %zu images not LOST; rms deviation from a line %.2f %% of its length, %.2f units\n", name,
              path.size(), images, 100.0 * std::sqrt(std::max(0.0, axes.eigenvalues()[0])) / (last - first),
              last - first);
}

/// How far the paths have drifted apart by `stamp`, laid upon each other at the estimate's first pose.
void print_drift(const char* name, const common::Trajectory2& estimate, const common::Trajectory2& truth,
                 common::Nanoseconds start, common::Nanoseconds stamp) {
  if (estimate.empty()) return;
  const auto true_first = common::pose_at(truth, estimate.front().stamp, common::kNanosecondsPerSecond);
  const auto true_here = common::pose_at(truth, stamp, common::kNanosecondsPerSecond);
  const auto here = common::pose_at(estimate, stamp, common::kNanosecondsPerSecond);
  if (!true_first || !true_here || !here) {
    std::printf("%-10s at %.1f s: no pose\n", name, common::to_seconds(stamp - start));
    return;
  }
  common::Trajectory2 driven;
  for (const common::StampedPose2& pose : truth) {
    if (pose.stamp >= estimate.front().stamp && pose.stamp <= stamp) driven.push_back(pose);
  }
  const double way = common::path_length(driven);
  const common::Pose2 moved = estimate.front().pose.inverse() * *here;
  const common::Pose2 true_move = true_first->inverse() * *true_here;
  const double error = (moved.translation() - true_move.translation()).norm();
  std::printf("%-10s at %.1f s: off by %.3f m, %.2f %% of %.1f m\n", name, common::to_seconds(stamp - start), error,
              100.0 * error / way, way);
}

/// A calibration that says the camera looks `degrees` farther to the left and stands `metres` farther ahead.
void falsify(common::CameraCalibration& camera, double degrees, double metres) {
  common::Pose3& mounting = camera.T_base_camera;
  const Eigen::AngleAxisd turn(common::to_radians(degrees), Eigen::Vector3d::UnitZ());
  mounting.rotation = Eigen::Quaterniond(turn) * mounting.rotation;
  mounting.translation.x() += metres;
}

int fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return EXIT_FAILURE;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3)
    return fail(
        "usage: benchmark_visual_accuracy RECORDING CAMERAS [THREADS] [mounting=DEG,METRES] [at=SECONDS] "
        "[visual.key=value ...]");
  visual_slam::VisualSlamOptions options;
  int threads = 1;
  double wrong_degrees = 0.0, wrong_metres = 0.0;
  std::vector<double> moments;
  for (int i = 3; i < argc; ++i) {
    const std::string argument = argv[i];
    if (std::sscanf(argument.c_str(), "mounting=%lf,%lf", &wrong_degrees, &wrong_metres) == 2) continue;
    if (double seconds = 0.0; std::sscanf(argument.c_str(), "at=%lf", &seconds) == 1) {
      moments.push_back(seconds);
      continue;
    }
    if (argument.find('=') == std::string::npos) {
      threads = std::atoi(argv[i]);
      continue;
    }
    const auto set = common::set_option(
        argument, [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) return fail(set.error().message);
  }
  auto recording = common::open_recording(argv[1]);
  if (!recording) return fail(recording.error().message);
  const auto truth = common::read_ground_truth(argv[1]);
  if (!truth) return fail(truth.error().message);
  std::map<std::string, common::CameraCalibration> cameras;
  std::istringstream names(argv[2]);
  for (std::string name; std::getline(names, name, ',');) {
    const auto& known = (*recording)->info().calibration.cameras;
    if (!known.contains(name)) return fail("the recording has no camera " + name);
    falsify(cameras.emplace(name, known.at(name)).first->second, wrong_degrees, wrong_metres);
  }
  auto slam = visual_slam::VisualSlam::create(options, cameras, 1, threads);
  if (!slam) return fail(slam.error().message);

  Run run;
  while (true) {
    auto item = (*recording)->next();
    if (!item) return fail(item.error().message);
    if (!*item) break;
    const auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message == nullptr) continue;
    if (const auto* odometry = std::get_if<common::WheelOdometry>(message)) {
      run.odometry.push_back({odometry->stamp, odometry->pose});
    }
    if (!(*slam)->wants(*message)) continue;
    const std::clock_t cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    const common::ProcessResult result = (*slam)->process(*message);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    run.cpu_seconds += static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    if (result.rejected) ++run.rejected;
    if (!result.estimate) continue;
    run.milliseconds.push_back(took.count());
    run.events.insert(run.events.end(), result.estimate->events.begin(), result.estimate->events.end());
    if (result.estimate->state != common::TrackingState::kLost) {
      run.online.push_back({result.estimate->stamp, result.estimate->pose});
    }
  }
  if (!truth->empty()) print_row("odometry", run.odometry, *truth);
  const auto align = options.motion.model == visual_slam::MotionModelKind::kOdometry
                         ? common::EvaluationAlignment::kSe2
                         : common::EvaluationAlignment::kSim2;
  if (!truth->empty()) {
    print_row("online", run.online, *truth, align);
    print_row("final", (*slam)->final_trajectory(), *truth, align);
    const common::Nanoseconds start = (*recording)->info().first_stamp;
    if (!run.online.empty()) moments.push_back(common::to_seconds(run.online.back().stamp - start));
    for (const double moment : moments) {
      const common::Nanoseconds stamp = start + common::from_seconds(moment);
      print_drift("odometry", run.odometry, *truth, start, stamp);
      print_drift("online", run.online, *truth, start, stamp);
    }
  } else {
    print_line_row("online", run.online, run.milliseconds.size());
    print_line_row("final", (*slam)->final_trajectory(), run.milliseconds.size());
  }
  std::sort(run.milliseconds.begin(), run.milliseconds.end());
  double sum = 0.0;
  for (const double value : run.milliseconds) sum += value;
  const std::size_t count = run.milliseconds.size();
  if (count > 0) {
    std::printf(
        "%zu images, %zu rejected; ms an image: mean %.2f median %.2f p95 %.2f max %.2f, of the processor %.2f; %zu "
        "landmarks\n",
        count, run.rejected, sum / static_cast<double>(count), run.milliseconds[count / 2],
        run.milliseconds[count * 95 / 100], run.milliseconds.back(), 1e3 * run.cpu_seconds / static_cast<double>(count),
        (*slam)->landmarks().size());
  }
  for (const common::Event& event : run.events) {
    std::printf("%.2f s %s: %s\n", common::to_seconds(event.stamp - (*recording)->info().first_stamp),
                event.kind.c_str(), event.detail.c_str());
  }
  if (const char* folder = std::getenv("SLAMFUSE_OUT")) {
    if (!common::write_tum(std::string(folder) + "/visual.tum", run.online) ||
        !common::write_tum(std::string(folder) + "/visual_final.tum", (*slam)->final_trajectory())) {
      return fail(std::string(folder) + ": cannot write");
    }
  }
  return EXIT_SUCCESS;
}
