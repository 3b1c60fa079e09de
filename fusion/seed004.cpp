// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/seed004.hpp"

#include <fmt/format.h>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "fusion/aligned_angle_search.hpp"
#include "fusion/curvature_filter.hpp"
#include "fusion/essential_matrix.hpp"
#include "fusion/heldout_split.hpp"
#include "fusion/pyramid_filter.hpp"
#include "fusion/trajectory_image.hpp"

namespace slamfuse::fusion {
namespace {

ImagePairs positions(const std::vector<PosePair>& pairs) {
  ImagePairs result;
  for (const PosePair& pair : pairs) {
    result.laser.push_back(pair.laser.translation());
    result.visual.push_back(pair.visual.translation());
  }
  return result;
}

ImagePairs move_both(const ImagePairs& pairs, const Eigen::Matrix4d& laser, const Eigen::Matrix4d& visual) {
  return {transformed(pairs.laser, laser), transformed(pairs.visual, visual)};
}

ImagePairs select(const ImagePairs& pairs, const std::vector<std::size_t>& indices) {
  ImagePairs selected;
  for (const std::size_t i : indices) {
    selected.laser.push_back(pairs.laser[i]);
    selected.visual.push_back(pairs.visual[i]);
  }
  return selected;
}

ImagePairs drop_sharp_turns(const ImagePairs& rotated, const Seed004Options& options) {
  if (!options.use_curvature_filter) return rotated;
  return select(rotated, filter_by_curvature(rotated.laser, rotated.visual, common::to_radians(options.curvature_angle),
                                             options.curvature_min_step));
}

/// T_ess if it lowers the residual on held-out pairs, else the identity; notes in `fit` which and why.
Eigen::Matrix4d find_essential(const ImagePairs& images, const Seed004Options& options, int heldout_block,
                               Seed004Fit& fit) {
  const Eigen::Matrix4d identity = Eigen::Matrix4d::Identity();
  if (!options.use_essential_matrix) {
    fit.essential_report = "identity: switched off";
    return identity;
  }
  const HeldoutSplit split(images.laser.size(), heldout_block);
  const ImagePairs training = {split.training(images.laser), split.training(images.visual)};
  const ImagePairs test = {split.test(images.laser), split.test(images.visual)};
  const ImagePairs smoothed =
      options.use_pyramid_filter ? filter_by_pyramid(training, options.pyramid_ratio) : training;
  const auto motion = estimate_essential_motion(smoothed, options.image_size);
  if (!motion || test.laser.empty()) {
    fit.essential_report = fmt::format("identity: {} pairs are too few", images.laser.size());
    return identity;
  }
  const double without = image_residual(test, identity);
  const double with = image_residual(test, motion->T_ess);
  fit.essential_applied = with < without;
  fit.essential_report = fmt::format("{}: held-out residual {:.2f} px with it, {:.2f} px without",
                                     fit.essential_applied ? "applied" : "identity", with, without);
  return fit.essential_applied ? motion->T_ess : identity;
}

}  // namespace

std::optional<Seed004Fit> fit_seed004(const std::vector<PosePair>& pairs, const Seed004Options& options,
                                      int heldout_block, double runner_up_separation) {
  Seed004Fit fit;
  MappingMatrix& g = fit.mapping;

  const ImagePairs paths = positions(pairs);
  const auto T_traj_laser = trajectory_image_matrix(paths.laser, options.image_size, ImagePlane::kLift);
  const auto T_traj_visual = trajectory_image_matrix(paths.visual, options.image_size, ImagePlane::kLift);
  if (!T_traj_laser || !T_traj_visual) return std::nullopt;
  g.T_traj_laser = *T_traj_laser;
  g.T_traj_visual = *T_traj_visual;
  const ImagePairs images = move_both(paths, g.T_traj_laser, g.T_traj_visual);

  const auto angles = search_aligned_angles(images.laser, images.visual, options.image_size,
                                            common::to_radians(options.angle_step), runner_up_separation);
  if (!angles) return std::nullopt;
  fit.loss = angles->loss;
  fit.runner_up_loss = angles->runner_up_loss;
  g.R_laser = aligned_angle_rotation(angles->laser);
  g.R_visual = aligned_angle_rotation(angles->visual);
  const ImagePairs rotated = move_both(images, g.R_laser, g.R_visual);

  const ImagePairs filtered = drop_sharp_turns(rotated, options);
  fit.kept_pairs = filtered.laser.size();

  const auto T_curv_laser = trajectory_image_matrix(filtered.laser, options.image_size, ImagePlane::kKeep);
  const auto T_curv_visual = trajectory_image_matrix(filtered.visual, options.image_size, ImagePlane::kKeep);
  if (!T_curv_laser || !T_curv_visual) return std::nullopt;
  g.T_curv_laser = *T_curv_laser;
  g.T_curv_visual = *T_curv_visual;
  const ImagePairs rescaled = move_both(filtered, g.T_curv_laser, g.T_curv_visual);

  g.T_ess = find_essential(rescaled, options, heldout_block, fit);
  if (g.planar().linear.determinant() <= 0.0) return std::nullopt;
  return fit;
}

}  // namespace slamfuse::fusion
