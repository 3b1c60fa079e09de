// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/essential_matrix.hpp"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace slamfuse::fusion {
namespace {

/// Image pixels to normalised image coordinates: the camera of a picture as wide as it is far away.
Eigen::Matrix4d normalisation(double size) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix(0, 0) = matrix(1, 1) = 1.0 / size;
  matrix(0, 3) = matrix(1, 3) = -0.5;
  return matrix;
}

Points moved_in_space(const Points& points, const Eigen::Matrix4d& T_ess) {
  Points moved;
  moved.reserve(points.size());
  for (const Eigen::Vector2d& p : points) {
    moved.push_back((T_ess * Eigen::Vector4d(p.x(), p.y(), 1.0, 1.0)).head<2>());
  }
  return moved;
}

/// The eight-point algorithm: the null vector of the rows kron(y_laser, y_visual), made an essential matrix by its
/// singular values (1, 1, 0).
Eigen::Matrix3d eight_points(const Points& laser, const Points& visual) {
  Eigen::Matrix<double, 9, 9> moments = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < laser.size(); ++i) {
    const Eigen::Vector3d l = laser[i].homogeneous();
    const Eigen::Vector3d v = visual[i].homogeneous();
    Eigen::Matrix<double, 9, 1> row;
    row << l[0] * v, l[1] * v, l[2] * v;
    moments += row * row.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(moments);
  const Eigen::Matrix<double, 9, 1> e = solver.eigenvectors().col(0);
  Eigen::Matrix3d E;
  E << e.head<3>().transpose(), e.segment<3>(3).transpose(), e.tail<3>().transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal() * svd.matrixV().transpose();
}

/// The two rotations an essential matrix leaves open, and the direction of the translation up to sign.
struct Decomposition {
  std::array<Eigen::Matrix3d, 2> rotations;
  Eigen::Vector3d direction;
};

Decomposition decompose(const Eigen::Matrix3d& E) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  Eigen::Matrix3d v = svd.matrixV();
  if (u.determinant() < 0.0) u = -u;
  if (v.determinant() < 0.0) v = -v;
  Eigen::Matrix3d w;
  w << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  return {{u * w * v.transpose(), u * w.transpose() * v.transpose()}, u.col(2)};
}

/// The signed length of `direction` that brings the rotated visual points closest to the laser points.
double best_length(const Points& laser, const Points& visual, const Eigen::Matrix3d& rotation,
                   const Eigen::Vector3d& direction) {
  constexpr double kSmallestSquare = 1e-12;  // a translation out of the image moves nothing in it
  const double square = direction.head<2>().squaredNorm() * static_cast<double>(laser.size());
  if (square < kSmallestSquare) return 0.0;
  double product = 0.0;
  for (std::size_t i = 0; i < laser.size(); ++i) {
    product += direction.head<2>().dot(laser[i] - (rotation * visual[i].homogeneous()).head<2>());
  }
  return product / square;
}

}  // namespace

double image_residual(const ImagePairs& pairs, const Eigen::Matrix4d& T_ess) {
  if (pairs.laser.empty()) return 0.0;
  const Points moved = moved_in_space(pairs.visual, T_ess);
  double sum = 0.0;
  for (std::size_t i = 0; i < moved.size(); ++i) sum += (pairs.laser[i] - moved[i]).squaredNorm();
  return std::sqrt(sum / static_cast<double>(moved.size()));
}

std::optional<EssentialMotion> estimate_essential_motion(const ImagePairs& pairs, double size) {
  constexpr std::size_t kFewestPairs = 8;
  if (pairs.laser.size() < kFewestPairs) return std::nullopt;
  const Eigen::Matrix4d to_normalised = normalisation(size);
  const Points laser = transformed(pairs.laser, to_normalised);
  const Points visual = transformed(pairs.visual, to_normalised);

  EssentialMotion motion;
  motion.E = eight_points(laser, visual);
  const Decomposition parts = decompose(motion.E);
  double smallest = std::numeric_limits<double>::infinity();
  for (const Eigen::Matrix3d& rotation : parts.rotations) {
    Eigen::Matrix4d normalised = Eigen::Matrix4d::Identity();
    normalised.topLeftCorner<3, 3>() = rotation;
    normalised.topRightCorner<3, 1>() = best_length(laser, visual, rotation, parts.direction) * parts.direction;
    const Eigen::Matrix4d T_ess = to_normalised.inverse() * normalised * to_normalised;
    const double residual = image_residual(pairs, T_ess);
    if (residual < smallest) {
      smallest = residual;
      motion.T_ess = T_ess;
    }
  }
  return motion;
}

}  // namespace slamfuse::fusion
