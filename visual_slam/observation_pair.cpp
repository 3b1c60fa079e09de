// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/observation_pair.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace slamfuse::visual_slam {
namespace {

constexpr double kClearlyPositive = 3.0;  // standard deviations of the depth; nearer to 0 samples would lie behind

double square(double value) { return value * value; }

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// One camera's frame in another: point_in_a = rotation point_in_b + translation.
struct CameraMotion {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;
};

/// The first camera's frame, at the exposure of its row, in the second's.
CameraMotion first_in_second(const ObservationPair& pair, const BodyPose& motion) {
  const auto camera_in_body = [&](const Camera& camera, const BodyPose& row_shift) {
    return CameraMotion{row_shift.rotation * camera.R_base_camera,
                        row_shift.rotation * (pair.lever_scale * camera.t_base_camera) + row_shift.position};
  };
  const CameraMotion first = camera_in_body(*pair.first_camera, pair.first.row_shift);
  const CameraMotion second = camera_in_body(*pair.second_camera, pair.second.row_shift);
  const Eigen::Matrix3d to_second = second.rotation.transpose() * motion.rotation.transpose();
  return {to_second * first.rotation,
          to_second * (first.translation - motion.position) - second.rotation.transpose() * second.translation};
}

/// Where the ray of the first bearing cuts the plane through the second optical centre and the line of the second image
/// on which along . point = b, with the derivatives of the depth.
struct Cut {
  Eigen::Vector3d ray;     // (u, v, 1)
  double depth;            // along the first optical axis
  Eigen::Vector2d by_ray;  // u, v
  double by_b;

  Cut(const CameraMotion& motion, const Eigen::Vector2d& along, const Eigen::Vector2d& first, double b)
      : ray(first.homogeneous()) {
    const Eigen::Vector3d normal(along.x(), along.y(), -b);
    const Eigen::Vector3d in_second = motion.rotation * ray;
    const double closing = normal.dot(in_second);
    depth = -normal.dot(motion.translation) / closing;
    by_ray = -depth / closing * (motion.rotation.leftCols<2>().transpose() * normal);
    by_b = (motion.translation.z() + depth * in_second.z()) / closing;
  }

  Eigen::Vector3d point() const { return depth * ray; }
  /// Determinant of the point's derivative by (u, v, b).
  double determinant() const { return depth * depth * by_b; }
  Eigen::Matrix3d point_by_bearings() const {
    Eigen::Matrix3d jacobian;
    jacobian << ray * by_ray.transpose(), ray * by_b;
    jacobian(0, 0) += depth;
    jacobian(1, 1) += depth;
    return jacobian;
  }
};

/// Derivative of the cut's depth by the six numbers of `motion`.
Eigen::Matrix<double, 1, 6> depth_by_motion(const ObservationPair& pair, const CameraMotion& cameras,
                                            const Eigen::Vector2d& along, const Cut& cut, double b) {
  const Eigen::Vector3d normal(along.x(), along.y(), -b);
  const BodyPose& row_shift = pair.second.row_shift;
  const Eigen::Matrix3d to_second =
      pair.second_camera->R_base_camera.transpose() * row_shift.rotation.transpose() * pair.motion.rotation.transpose();
  // In the axes of the earlier pose: the landmark as seen from the later pose, which is what the motion moves.
  const Eigen::Vector3d landmark =
      to_second.transpose() * (cameras.rotation * cut.point() + cameras.translation) +
      pair.motion.rotation *
          (row_shift.rotation * (pair.lever_scale * pair.second_camera->t_base_camera) + row_shift.position);
  const Eigen::Vector3d turned_normal = to_second.transpose() * normal;
  Eigen::Matrix<double, 1, 6> jacobian;
  jacobian << turned_normal.transpose(), -turned_normal.transpose() * cross_matrix(landmark);
  return jacobian / normal.dot(cameras.rotation * cut.ray);
}

/// Gaussian numbers that are the same with every standard library.
class Gaussians {
 public:
  double operator()() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * std::numbers::pi * uniform()); }

 private:
  double uniform() { return (static_cast<double>(engine_()) + 0.5) / 4294967296.0; }

  std::mt19937 engine_{1};
};

}  // namespace

std::optional<Intersection> intersect(const ObservationPair& pair) {
  const CameraMotion cameras = first_in_second(pair, pair.motion);
  const Eigen::Vector3d ray = cameras.rotation * pair.first.point.homogeneous();
  const Eigen::Vector2d line = ray.z() * cameras.translation.head<2>() - cameras.translation.z() * ray.head<2>();
  if (!(line.norm() > std::numeric_limits<double>::epsilon())) return std::nullopt;
  const Eigen::Vector2d along = line.normalized();
  const Cut cut(cameras, along, pair.first.point, along.dot(pair.second.point));
  const double inverse_depth = 1.0 / cut.depth;
  if (!std::isfinite(inverse_depth)) return std::nullopt;
  return Intersection{inverse_depth, along};
}

double divergence_from_gaussian(const ObservationPair& pair, const Intersection& at, int samples) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const double b = at.along.dot(pair.second.point);
  const CameraMotion cameras = first_in_second(pair, pair.motion);
  const Cut mean(cameras, at.along, pair.first.point, b);
  const Eigen::Matrix<double, 1, 6> depth_by_pose = depth_by_motion(pair, cameras, at.along, mean, b);
  const double depth_sigma =
      std::sqrt(depth_by_pose * pair.motion_covariance * depth_by_pose.transpose() +
                square(pair.first.sigma) * mean.by_ray.squaredNorm() + square(pair.second.sigma * mean.by_b));
  if (!(mean.depth > kClearlyPositive * depth_sigma)) return kInfinite;

  const Eigen::Matrix3d to_bearings = mean.point_by_bearings().inverse();
  const Matrix36 point_by_pose = mean.ray * depth_by_pose;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> axes(pair.motion_covariance);
  const Eigen::Matrix<double, 6, 6> root =
      axes.eigenvectors() * axes.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const Eigen::Vector3d sigmas(pair.first.sigma, pair.first.sigma, pair.second.sigma);
  Gaussians gaussian;
  double sum = 0.0;
  const int pairs = std::max(1, samples / 2);
  for (int i = 0; i < pairs; ++i) {
    Vector6 motion_draw;
    for (double& number : motion_draw) number = gaussian();
    Eigen::Vector3d bearing_draw;
    for (double& number : bearing_draw) number = gaussian();
    for (const double sign : {1.0, -1.0}) {  // each draw and its opposite, so that odd terms cancel
      const Vector6 moved = sign * root * motion_draw;
      const Eigen::Vector3d bearings = sign * sigmas.cwiseProduct(bearing_draw);
      BodyPose motion = pair.motion;
      motion.position += moved.head<3>();
      motion.rotation = rotation_exp(moved.tail<3>()).toRotationMatrix() * motion.rotation;
      const Cut cut(first_in_second(pair, motion), at.along, pair.first.point + bearings.head<2>(), b + bearings.z());
      if (!(cut.depth > 0.0) || !std::isfinite(cut.depth)) return kInfinite;
      // The bearings the linearised map would need to reach the sampled point.
      const Eigen::Vector3d needed = to_bearings * (cut.point() - mean.point() - point_by_pose * moved);
      sum += -std::log(std::abs(cut.determinant() / mean.determinant())) +
             0.5 * (needed.cwiseQuotient(sigmas).squaredNorm() - bearing_draw.squaredNorm());
    }
  }
  return sum / (2.0 * pairs);
}

std::optional<PairPoint> point_of_pair(const ObservationPair& pair, const Intersection& at,
                                       const BodyPose& anchor_pose) {
  if (!(at.inverse_depth > 0.0)) return std::nullopt;
  const BodyPose robot = anchor_pose * pair.motion;
  const Anchor anchor{pair.first_camera, pair.first.row_shift};
  const Eigen::Vector3d numbers(pair.first.point.x(), pair.first.point.y(), at.inverse_depth);
  const std::optional<Projection> seen = project_anchored(*pair.second_camera, pair.second.row_shift, robot, anchor,
                                                          anchor_pose, numbers, pair.lever_scale);
  if (!seen) return std::nullopt;
  const CartesianPoint place = to_cartesian(anchor, anchor_pose, numbers, pair.lever_scale);
  // The inverse depth is what puts the landmark at the measured place along the line:
  // along . (h + H e) = along . z, solved for the error of the inverse depth.
  const Eigen::RowVector2d along = at.along.transpose();
  const Eigen::Vector3d by_measured = place.wrt_landmark.col(2) / along.dot(seen->wrt_landmark.col(2));
  const Eigen::Matrix<double, 3, 2> by_shift = by_measured * along;
  PairPoint point;
  point.position = place.position;
  point.wrt_robot = -by_shift * seen->wrt_robot;
  point.wrt_anchor = place.wrt_anchor - by_shift * seen->wrt_anchor;
  point.wrt_lever_scale = place.wrt_lever_scale - by_shift * seen->wrt_lever_scale;
  const Eigen::Matrix<double, 3, 2> by_first =
      place.wrt_landmark.leftCols<2>() - by_shift * seen->wrt_landmark.leftCols<2>();
  point.covariance = square(pair.first.sigma) * by_first * by_first.transpose() +
                     square(pair.second.sigma) * by_measured * by_measured.transpose();
  return point;
}

}  // namespace slamfuse::visual_slam
