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

#include <Eigen/Cholesky>

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
constexpr int kParts = 10;      // of the time, in the output
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

/// Errors over their standard deviations: of the heading; of the place along the robot's axis, given the heading;
/// across it, given both; of the three systematic errors of the odometry. Each has a mean square of 1 when all is
/// right.
Eigen::Matrix<double, 6, 1> normalised_parts(const BearingSimulation& simulation, const visual_slam::Ekf& filter) {
  const double theta = simulation.truth().theta;
  Eigen::Matrix3d order;  // (x, y, theta) to (theta, along, across)
  order << 0.0, 0.0, 1.0, std::cos(theta), std::sin(theta), 0.0, -std::sin(theta), std::cos(theta), 0.0;
  const Eigen::LLT<Eigen::Matrix3d> llt(order * filter.pose_covariance() * order.transpose());
  Eigen::Matrix<double, 6, 1> parts;
  parts.head<3>() = llt.matrixL().solve(order * simulation.error_of(filter));
  parts.tail<3>() = (simulation.calibration() - filter.motion_parameters())
                        .cwiseQuotient(filter.state().covariance(1, 1).diagonal().cwiseSqrt());
  return parts;
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
  // Error over its standard deviation, of the heading, of the place along and across given what is before, of a, b, c.
  std::vector<Eigen::Matrix<double, 6, 1>> mean_parts(path.size(), Eigen::Matrix<double, 6, 1>::Zero());
  auto square_parts = mean_parts;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double position_square = 0.0, scale_square = 0.0, scale_mean = 0.0;
  for (int run = 0; run < runs; ++run) {
    BearingSimulation simulation(1000U + static_cast<unsigned>(run), numbers[1], path, points, kReach);
    visual_slam::Ekf filter(options.filter,
                            visual_slam::for_cameras(options.motion, static_cast<std::size_t>(numbers[1])));
    simulation.assumed_pixel_sigma = options.filter.pixel_sigma;
    simulation.max_landmarks = static_cast<std::size_t>(options.map.max_landmarks);
    for (std::size_t i = 1; !simulation.done(); ++i) {
      simulation.step(filter);
      nees[i] += simulation.nees(filter) / runs;
      const Eigen::Vector3d error = simulation.error_of(filter);
      squares += (error.array().square() / filter.pose_covariance().diagonal().array()).matrix();
      position_square += error.head<2>().squaredNorm();
      const Eigen::Matrix<double, 6, 1> parts = normalised_parts(simulation, filter);
      mean_parts[i] += parts / runs;
      square_parts[i] += parts.cwiseAbs2() / runs;
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
  std::printf(
      "over time: NEES; mean and mean square of heading, along, across, a, b, c over their standard deviations\n");
  for (int part = 0; part < kParts; ++part) {
    const std::size_t from = 1 + static_cast<std::size_t>(part) * (nees.size() - 1) / kParts;
    const std::size_t to = 1 + static_cast<std::size_t>(part + 1) * (nees.size() - 1) / kParts;
    const double images = static_cast<double>(to - from);
    double mean = 0.0;
    Eigen::Matrix<double, 6, 1> parts_mean = Eigen::Matrix<double, 6, 1>::Zero(), parts_square = parts_mean;
    for (std::size_t i = from; i < to; ++i) {
      mean += nees[i] / images;
      parts_mean += mean_parts[i] / images;
      parts_square += square_parts[i] / images;
    }
    std::printf("%5.0f s %6.2f ", static_cast<double>(to) * common::to_seconds(BearingSimulation::kFrame), mean);
    for (int k = 0; k < 6; ++k) std::printf(" %6.2f %5.2f", parts_mean[k], parts_square[k]);
    std::printf("\n");
  }
  return EXIT_SUCCESS;
}
