// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/projection.hpp"

#include <cmath>
#include <limits>

namespace slamfuse::visual_slam {
namespace {

constexpr double kMinDepth = 1e-3;  // scaled depth below which a point counts as behind the camera

/// The pinhole: a point g = rho q (q in base_link at the stamp) and its derivatives.
struct Pinhole {
  Eigen::Vector2d point;
  Eigen::Matrix<double, 2, 3> wrt_scaled_point;
  Eigen::Vector2d wrt_rho;
  Eigen::Vector2d wrt_lever_scale;  ///< while g stays
};

std::optional<Pinhole> see(const Camera& camera, const BodyPose& row_shift, const Eigen::Vector3d& g, double rho,
                           double lever_scale) {
  const Eigen::Matrix3d turn = camera.R_base_camera.transpose() * row_shift.rotation.transpose();
  const Eigen::Vector3d lever = camera.R_base_camera.transpose() * (lever_scale * camera.t_base_camera);
  const Eigen::Vector3d offset = turn * row_shift.position + lever;
  const Eigen::Vector3d in_camera = turn * g - rho * offset;
  if (!(in_camera.z() > kMinDepth)) return std::nullopt;
  const Eigen::Vector2d point = in_camera.head<2>() / in_camera.z();
  Eigen::Matrix<double, 2, 3> by_camera_point;
  by_camera_point << 1.0, 0.0, -point.x(), 0.0, 1.0, -point.y();
  by_camera_point /= in_camera.z();
  return Pinhole{point, by_camera_point * turn, -by_camera_point * offset, -rho * (by_camera_point * lever)};
}

}  // namespace

std::optional<Projection> project_cartesian(const Camera& camera, const BodyPose& row_shift, const BodyPose& robot,
                                            const Eigen::Vector3d& landmark, double lever_scale) {
  const Eigen::Matrix3d to_robot = robot.rotation.transpose();
  const Eigen::Vector3d in_base = to_robot * (landmark - robot.position);
  const std::optional<Pinhole> seen = see(camera, row_shift, in_base, 1.0, lever_scale);
  if (!seen) return std::nullopt;
  Projection projection;
  projection.point = seen->point;
  projection.wrt_landmark = seen->wrt_scaled_point * to_robot;
  projection.wrt_robot.leftCols<3>() = -projection.wrt_landmark;
  projection.wrt_robot.rightCols<3>() = seen->wrt_scaled_point * (cross_matrix(in_base) * to_robot);
  projection.wrt_anchor.setZero();
  projection.wrt_lever_scale = seen->wrt_lever_scale;
  return projection;
}

std::optional<Projection> project_anchored(const Camera& camera, const BodyPose& row_shift, const BodyPose& robot,
                                           const Anchor& anchor, const BodyPose& anchor_pose,
                                           const Eigen::Vector3d& landmark, double lever_scale) {
  const double rho = landmark.z();
  const Eigen::Matrix3d to_robot = robot.rotation.transpose();
  const Eigen::Matrix3d& anchor_turn = anchor_pose.rotation;
  const Eigen::Matrix3d& row_turn = anchor.row_shift.rotation;
  const Eigen::Matrix3d ray_turn = anchor_turn * row_turn * anchor.camera->R_base_camera;
  const Eigen::Vector3d camera_lever = row_turn * (lever_scale * anchor.camera->t_base_camera);
  const Eigen::Vector3d lever = anchor_turn * (camera_lever + anchor.row_shift.position);
  const Eigen::Vector3d from_anchor =
      ray_turn * Eigen::Vector3d(landmark.x(), landmark.y(), 1.0) + rho * lever;  // times rho, turned as the map
  const Eigen::Vector3d baseline = anchor_pose.position - robot.position;
  const Eigen::Vector3d g = to_robot * (from_anchor + rho * baseline);
  const std::optional<Pinhole> seen = see(camera, row_shift, g, rho, lever_scale);
  if (!seen) return std::nullopt;

  Projection projection;
  projection.point = seen->point;
  const Eigen::Matrix<double, 2, 3> wrt_map_point = seen->wrt_scaled_point * to_robot;
  projection.wrt_robot.leftCols<3>() = -rho * wrt_map_point;
  projection.wrt_robot.rightCols<3>() = seen->wrt_scaled_point * (cross_matrix(g) * to_robot);
  projection.wrt_anchor.leftCols<3>() = rho * wrt_map_point;
  projection.wrt_anchor.rightCols<3>() = wrt_map_point * -cross_matrix(from_anchor);
  projection.wrt_landmark.leftCols<2>() = wrt_map_point * ray_turn.leftCols<2>();
  projection.wrt_landmark.col(2) = wrt_map_point * (lever + baseline) + seen->wrt_rho;
  projection.wrt_lever_scale = rho * (wrt_map_point * (anchor_turn * camera_lever)) + seen->wrt_lever_scale;
  return projection;
}

CartesianPoint to_cartesian(const Anchor& anchor, const BodyPose& anchor_pose, const Eigen::Vector3d& landmark,
                            double lever_scale) {
  const double depth = 1.0 / landmark.z();
  const Eigen::Matrix3d& row_turn = anchor.row_shift.rotation;
  const Eigen::Matrix3d& anchor_turn = anchor_pose.rotation;
  const Eigen::Matrix3d ray_turn = anchor_turn * row_turn * anchor.camera->R_base_camera;
  const Eigen::Vector3d ray = ray_turn * Eigen::Vector3d(landmark.x(), landmark.y(), 1.0);
  const Eigen::Vector3d camera_lever = row_turn * (lever_scale * anchor.camera->t_base_camera);
  const Eigen::Vector3d lever = anchor_turn * (camera_lever + anchor.row_shift.position);
  CartesianPoint point;
  point.position = anchor_pose.position + lever + depth * ray;
  point.wrt_anchor << Eigen::Matrix3d::Identity(), -cross_matrix(lever + depth * ray);
  point.wrt_landmark.leftCols<2>() = depth * ray_turn.leftCols<2>();
  point.wrt_landmark.col(2) = -depth * depth * ray;
  point.wrt_lever_scale = anchor_turn * camera_lever;
  return point;
}

Eigen::Vector3d optical_centre(const Camera& camera, const BodyPose& robot, double lever_scale) {
  return robot.position + robot.rotation * (lever_scale * camera.t_base_camera);
}

double linearity_index(const Eigen::Vector3d& anchor_centre, const Eigen::Vector3d& camera_centre,
                       const Eigen::Vector3d& point, double rho, double rho_sigma) {
  if (rho <= 0.0) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d from_anchor = point - anchor_centre;
  const Eigen::Vector3d from_camera = point - camera_centre;
  const double cosine = from_anchor.dot(from_camera) / (from_anchor.norm() * from_camera.norm());
  return 4.0 * rho_sigma / (rho * rho * from_camera.norm()) * std::abs(cosine);
}

}  // namespace slamfuse::visual_slam
