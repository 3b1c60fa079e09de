// SPDX-License-Identifier: BSD-3-Clause
#include "service/align_command.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/trajectory.hpp"
#include "common/tum.hpp"
#include "fusion/alignment.hpp"
#include "fusion/plane_of_motion.hpp"
#include "service/map_picture.hpp"
#include "service/metrics.hpp"
#include "service/output_folder.hpp"
#include "service/run_files.hpp"

namespace slamfuse::service {
namespace {

std::string picture_of(const common::Trajectory2& laser, const common::Trajectory2& visual_aligned) {
  MapPicture picture;
  picture.paths = {{"laser", "laser", laser}, {"visual", "visual", visual_aligned}};
  return map_picture_file(picture);
}

std::string in_words(const fusion::Alignment& alignment) {
  return fmt::format(
      "alignment {}: {}\n"
      "  method         {}\n"
      "  scale          {:.5f} {:.5f}\n"
      "  rotation       {:.3f} deg\n"
      "  rmse           {:.4f} m over {} of {} pairs\n"
      "  held-out rmse  {:.4f} m\n"
      "  runner-up      {:.2f} times the loss\n",
      alignment.accepted ? "accepted" : "refused", alignment.reason, to_string(alignment.method), alignment.scale.x(),
      alignment.scale.y(), alignment.rotation_deg, alignment.rmse, alignment.inliers, alignment.pairs,
      alignment.heldout_rmse, alignment.runner_up_ratio);
}

}  // namespace

common::Result<std::string> run_align(const AlignRequest& request) {
  const auto laser = common::read_trajectory(request.laser);
  if (!laser) return tl::unexpected(laser.error());
  const auto visual = common::read_trajectory(request.visual);
  if (!visual) return tl::unexpected(visual.error());
  auto folder = OutputFolder::create(request.out, ResultKind::kAlignment);
  if (!folder) return tl::unexpected(folder.error());

  const fusion::SpatialAlignment aligned = fusion::align_spatial(*laser, *visual, request.options);
  const fusion::Alignment& alignment = aligned.alignment;

  nlohmann::ordered_json metrics{{"slamfuse", program_version()},
                                 {"seed", request.seed},
                                 {"laser", request.laser.string()},
                                 {"visual", request.visual.string()},
                                 {"alignment", alignment_metrics(alignment)}};
  if (auto written = (*folder)->write("metrics.json", json_text(metrics)); !written) {
    return tl::unexpected(written.error());
  }
  if (alignment.accepted) {
    const auto visual_aligned = fusion::to_laser_frame(aligned.visual, alignment);
    if (auto written = (*folder)->write("visual_aligned.tum", trajectory_file(visual_aligned, request.seed));
        !written) {
      return tl::unexpected(written.error());
    }
    if (auto written = (*folder)->write("trajectories.svg", picture_of(aligned.laser, visual_aligned)); !written) {
      return tl::unexpected(written.error());
    }
  }
  if (auto published = (*folder)->publish(); !published) return tl::unexpected(published.error());
  if (!alignment.accepted) return common::failed("alignment refused: " + alignment.reason);
  return in_words(alignment);
}

}  // namespace slamfuse::service
