// SPDX-License-Identifier: BSD-3-Clause
#include "common/offset_fit.hpp"

#include <cmath>

#include <Eigen/QR>

#include "common/angle.hpp"
#include "common/similarity2.hpp"

namespace slamfuse::common {
namespace {

constexpr int kMaxIterations = 20;
constexpr double kSmallStep = 1e-10;
constexpr double kRankTolerance = 1e-6;  ///< smaller singular values are directions the path leaves open

std::optional<Pose2> rigid_fit(const std::vector<Pose2>& estimate, const std::vector<Pose2>& reference) {
  std::vector<Eigen::Vector2d> source;
  std::vector<Eigen::Vector2d> target;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    source.push_back(estimate[i].translation());
    target.push_back(reference[i].translation());
  }
  const auto fit = fit_similarity(source, target, FitGroup::kRigid);
  return fit ? std::optional(fit->pose) : std::nullopt;
}

}  // namespace

std::optional<OffsetFit> fit_offset(const std::vector<Pose2>& estimate, const std::vector<Pose2>& reference) {
  constexpr std::size_t kFewest = 3;
  const auto begin = rigid_fit(estimate, reference);
  if (estimate.size() < kFewest || !begin) return std::nullopt;
  Pose2 frame = *begin;
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  const auto count = static_cast<Eigen::Index>(estimate.size());
  Eigen::VectorXd residual(2 * count);
  Eigen::MatrixXd jacobian(2 * count, 5);  // x, y, theta of the frame, then the offset
  const auto linearise = [&] {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Pose2& pose = estimate[static_cast<std::size_t>(i)];
      const Eigen::Vector2d turned = frame.rotation() * (pose * offset);
      residual.segment<2>(2 * i) = turned + frame.translation() - reference[static_cast<std::size_t>(i)].translation();
      jacobian.block<2, 2>(2 * i, 0).setIdentity();
      jacobian.block<2, 1>(2 * i, 2) = Eigen::Vector2d(-turned.y(), turned.x());
      jacobian.block<2, 2>(2 * i, 3) = (frame * pose).rotation();
    }
  };
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    linearise();
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(kRankTolerance);
    solver.compute(jacobian);
    const Eigen::VectorXd step = solver.solve(-residual);
    frame.x += step[0];
    frame.y += step[1];
    frame.theta = normalize_angle(frame.theta + step[2]);
    offset += step.tail<2>();
    if (step.norm() < kSmallStep) break;
  }
  linearise();
  Eigen::Vector2d heading = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const double difference = angle_difference(reference[i].theta, (frame * estimate[i]).theta);
    heading += Eigen::Vector2d(std::cos(difference), std::sin(difference));
  }
  return OffsetFit{frame,
                   {offset.x(), offset.y(), std::atan2(heading.y(), heading.x())},
                   std::sqrt(residual.squaredNorm() / static_cast<double>(count))};
}

}  // namespace slamfuse::common
