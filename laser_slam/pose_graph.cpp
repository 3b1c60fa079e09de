// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/pose_graph.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include <ceres/ceres.h>
#include <Eigen/Eigenvalues>

#include "common/angle.hpp"

namespace slamfuse::laser_slam {
namespace {

/// A root R of a positive semidefinite matrix: R' R is the matrix. Unlike Cholesky's it exists for singular ones.
Eigen::Matrix3d root(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(matrix);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.eigenvectors().transpose();
}

class RelativePoseError {
 public:
  explicit RelativePoseError(const PoseConstraint& constraint)
      : measured_(constraint.measured), root_(root(constraint.information)) {}

  template <class T>
  bool operator()(const T* from, const T* to, T* residual) const {
    using std::cos;
    using std::floor;
    using std::sin;
    const T cosine = cos(from[2]);
    const T sine = sin(from[2]);
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    T turn = to[2] - from[2] - measured_.theta;
    turn -= 2.0 * std::numbers::pi * floor((turn + std::numbers::pi) / (2.0 * std::numbers::pi));
    const Eigen::Matrix<T, 3, 1> error(cosine * dx + sine * dy - measured_.x, -sine * dx + cosine * dy - measured_.y,
                                       turn);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> result(residual);
    result = root_.cast<T>() * error;
    return true;
  }

 private:
  common::Pose2 measured_;
  Eigen::Matrix3d root_;
};

}  // namespace

std::vector<common::Pose2> optimise_poses(const std::vector<common::Pose2>& initial,
                                          const std::vector<PoseConstraint>& constraints, double loop_outlier) {
  if (initial.size() < 2 || constraints.empty()) return initial;
  std::vector<std::array<double, 3>> values;
  values.reserve(initial.size());
  for (const common::Pose2& pose : initial) values.push_back({pose.x, pose.y, pose.theta});

  ceres::Problem problem;
  for (std::array<double, 3>& value : values) problem.AddParameterBlock(value.data(), 3);
  problem.SetParameterBlockConstant(values.front().data());
  for (const PoseConstraint& constraint : constraints) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RelativePoseError, 3, 3, 3>(new RelativePoseError(constraint)),
        constraint.loop ? new ceres::CauchyLoss(loop_outlier) : nullptr,
        values[static_cast<std::size_t>(constraint.from)].data(),
        values[static_cast<std::size_t>(constraint.to)].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Not SuiteSparse: its sums depend on the BLAS that is installed.
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.max_num_iterations = 50;
  options.num_threads = 1;  // sums in one fixed order
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return initial;

  std::vector<common::Pose2> result;
  result.reserve(values.size());
  for (const auto& value : values) result.push_back({value[0], value[1], common::normalize_angle(value[2])});
  return result;
}

}  // namespace slamfuse::laser_slam
