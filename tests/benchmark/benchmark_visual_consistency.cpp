// SPDX-License-Identifier: BSD-3-Clause
// How well the visual filter knows its own error: simulated bearings and odometry along the true path of a recording,
// the noise drawn anew in each run. Prints the NEES of the pose (3 is right) over time and the share of the time its
// mean over the runs is inside the 95 % band.
//
//     benchmark_visual_consistency RECORDING [RUNS] [CAMERAS] [visual.key=value ...]
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/trajectory.hpp"
#include "visual_slam/bearing_simulation.hpp"
#include "visual_slam/options.hpp"

namespace {

using namespace slamfuse;
using visual_slam::testing::BearingSimulation;
using visual_slam::testing::Noise;

constexpr double kFreedoms = 3.0;       // of a planar pose
constexpr double kQuantile = 1.959964;  // of the normal distribution, for 95 %
constexpr int kPoints = 1500;
constexpr double kReach = 6.0;  // [m] as far as a feature is seen

int fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return EXIT_FAILURE;
}

/// The true poses at the image rate.
std::vector<common::Pose2> sampled(const common::Trajectory2& truth) {
  std::vector<common::Pose2> path;
  common::Nanoseconds next = truth.front().stamp;
  for (const auto& [stamp, pose] : truth) {
    if (stamp < next) continue;
    path.push_back(pose);
    next = stamp + BearingSimulation::kFrame;
  }
  return path;
}

/// Points around the path, in the frame of its first pose.
std::vector<Eigen::Vector3d> points_around(const std::vector<common::Pose2>& path) {
  Noise noise(1);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < kPoints; ++i) {
    const common::Pose2 from =
        path.front().inverse() * path[static_cast<std::size_t>(noise.uniform() * static_cast<double>(path.size()))];
    const double angle = 2.0 * std::numbers::pi * noise.uniform();
    const double distance = 1.0 + 4.0 * noise.uniform();
    points.emplace_back(from.x + distance * std::cos(angle), from.y + distance * std::sin(angle),
                        2.2 * noise.uniform());
  }
  return points;
}

/// Quantile of the chi-square distribution by Wilson and Hilferty's approximation.
double chi_square_quantile(double freedoms, double normal_quantile) {
  const double share = 2.0 / (9.0 * freedoms);
  return freedoms * std::pow(1.0 - share + normal_quantile * std::sqrt(share), 3);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return fail("usage: benchmark_visual_consistency RECORDING [RUNS] [CAMERAS] [visual.key=value ...]");
  visual_slam::VisualSlamOptions options;
  int numbers[] = {20, 1};
  int given = 0;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.find('=') == std::string::npos) {
      if (given < 2) numbers[given++] = std::atoi(argv[i]);
      continue;
    }
    const auto set = common::set_option(
        argument, [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) return fail(set.error().message);
  }
  const auto truth = common::read_ground_truth(argv[1]);
  if (!truth) return fail(truth.error().message);
  const std::vector<common::Pose2> path = sampled(*truth);
  const std::vector<Eigen::Vector3d> points = points_around(path);
  const int runs = numbers[0];

  std::vector<double> nees(path.size(), 0.0);
  std::vector<Eigen::Vector3d> normalised(path.size(), Eigen::Vector3d::Zero());
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double position_square = 0.0, scale_square = 0.0, scale_mean = 0.0;
  for (int run = 0; run < runs; ++run) {
    BearingSimulation simulation(1000U + static_cast<unsigned>(run), numbers[1], path, points, kReach);
    visual_slam::Ekf filter(options.filter, options.motion);
    simulation.assumed_pixel_sigma = options.filter.pixel_sigma;
    simulation.max_landmarks = static_cast<std::size_t>(options.map.max_landmarks);
    for (std::size_t i = 1; !simulation.done(); ++i) {
      simulation.step(filter);
      nees[i] += simulation.nees(filter) / runs;
      const Eigen::Vector3d error = simulation.error_of(filter);
      squares += (error.array().square() / filter.pose_covariance().diagonal().array()).matrix();
      position_square += error.head<2>().squaredNorm();
    }
    const double z = (simulation.calibration()[0] - filter.motion_parameters()[0]) /
                     std::sqrt(filter.state().covariance(1, 1)(0, 0));
    scale_square += z * z / runs;
    scale_mean += z / runs;
  }
  const double freedoms = kFreedoms * runs;
  const double low = chi_square_quantile(freedoms, -kQuantile) / runs;
  const double high = chi_square_quantile(freedoms, kQuantile) / runs;
  int inside = 0, below = 0;
  double sum = 0.0;
  for (std::size_t i = 1; i < nees.size(); ++i) {
    inside += nees[i] >= low && nees[i] <= high ? 1 : 0;
    below += nees[i] < low ? 1 : 0;
    sum += nees[i];
  }
  const double count = static_cast<double>(nees.size() - 1);
  squares /= count * runs;
  std::printf(
      "%d runs, %zu images: NEES mean %.2f, band [%.2f, %.2f], inside %.1f %%, below %.1f %%; by itself x %.2f y %.2f "
      "theta %.2f; "
      "rms %.3f m; scale at the end %.2f (mean %.2f)\n",
      runs, nees.size() - 1, sum / count, low, high, 100.0 * inside / count, 100.0 * below / count, squares[0],
      squares[1], squares[2], std::sqrt(position_square / (count * runs)), scale_square, scale_mean);
  std::printf("over time:");
  for (int part = 0; part < 10; ++part) {
    double mean = 0.0;
    const std::size_t from = 1 + static_cast<std::size_t>(part) * (nees.size() - 1) / 10;
    const std::size_t to = 1 + static_cast<std::size_t>(part + 1) * (nees.size() - 1) / 10;
    for (std::size_t i = from; i < to; ++i) mean += nees[i];
    std::printf(" %.2f", mean / static_cast<double>(to - from));
  }
  std::printf("\n");
  return EXIT_SUCCESS;
}
