// SPDX-License-Identifier: BSD-3-Clause
// The ablation table of fusion/README.md: every method, and seed 004 without each of its steps, on a real drive and on
// synthetic ones of which the map is known. Further pairs of trajectories can be named on the command line:
//
//     fusion_ablation [LASER.tum VISUAL.tum]...
//
// The real drive is looked for in $SLAMFUSE_RECORDINGS and left out, saying so, without it.

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "common/angle.hpp"
#include "common/tum.hpp"
#include "fusion/plane_of_motion.hpp"
#include "fusion/synthetic_trajectory.hpp"

namespace {

using namespace slamfuse;
using fusion::AlignmentMethod;
using fusion::AlignmentOptions;

/// Two trajectories, and the map between them where it is known.
struct Drive {
  std::string name;
  common::Trajectory3 laser;
  common::Trajectory3 visual;
  std::optional<fusion::PlanarAffine> truth;
};

struct Variant {
  std::string name;
  AlignmentOptions options;
};

std::vector<Variant> variants() {
  std::vector<Variant> list;
  for (const auto method : {AlignmentMethod::kAuto, AlignmentMethod::kRigid, AlignmentMethod::kSimilarity,
                            AlignmentMethod::kAffine, AlignmentMethod::kSeed004}) {
    AlignmentOptions options;
    options.method = method;
    list.push_back({to_string(method), options});
  }
  const AlignmentOptions seed = list.back().options;
  list.push_back({"auto, no clock offset and lever arm", {}});
  list.back().options.offsets.estimate = false;
  list.push_back({"seed004, no curvature filter", seed});
  list.back().options.seed004.use_curvature_filter = false;
  list.push_back({"seed004, no pyramid filter", seed});
  list.back().options.seed004.use_pyramid_filter = false;
  list.push_back({"seed004, no essential matrix", seed});
  list.back().options.seed004.use_essential_matrix = false;
  return list;
}

Drive synthetic(const std::string& name, double noise, double outliers, double scale_x, double scale_y) {
  const auto laser = fusion::flat_path();
  const fusion::PlanarAffine truth = fusion::stretched_map(37.0, scale_x, scale_y, 2.0, -3.0);
  const auto visual = fusion::visual_path(laser, truth, noise / scale_x, outliers, 1);
  return {name, common::to_spatial(laser), common::to_spatial(visual), truth};
}

std::optional<Drive> from_files(const std::string& name, const std::filesystem::path& laser,
                                const std::filesystem::path& visual) {
  auto l = common::read_trajectory(laser);
  auto v = common::read_trajectory(visual);
  if (!l || !v) {
    fmt::print(stderr, "{}\n", l ? v.error().message : l.error().message);
    return std::nullopt;
  }
  return Drive{name, *l, *v, std::nullopt};
}

void print_row(const Variant& variant, const Drive& drive) {
  const auto start = std::chrono::steady_clock::now();
  const fusion::Alignment a = fusion::align_spatial(drive.laser, drive.visual, variant.options).alignment;
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  std::string errors = "| ";
  if (drive.truth) {
    const auto parts = fusion::take_apart(*drive.truth);
    const double turn = common::angle_difference(common::to_radians(a.rotation_deg), parts.rotation);
    errors = fmt::format("{:.2f} deg, {:.2f} % {:.2f} % |", std::abs(common::to_degrees(turn)),
                         100.0 * std::abs(a.scale.x() / parts.scale.x() - 1.0),
                         100.0 * std::abs(a.scale.y() / parts.scale.y() - 1.0));
  }
  fmt::print("| {} | {} | {:.2f} | {:.4f} {:.4f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {} {:.1f} |\n", variant.name,
             a.accepted ? "accepted" : "refused", a.rotation_deg, a.scale.x(), a.scale.y(), 100.0 * a.rmse,
             100.0 * a.heldout_rmse, 100.0 * a.rmse_all, a.runner_up_ratio, errors, ms);
  if (!a.essential_report.empty())
    fmt::print(stderr, "{}, {}: T_ess {}\n", drive.name, variant.name, a.essential_report);
  if (!a.accepted) fmt::print(stderr, "{}, {}: {}\n", drive.name, variant.name, a.reason);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<Drive> drives;
  if (const char* recordings = std::getenv("SLAMFUSE_RECORDINGS")) {
    const std::filesystem::path folder = std::filesystem::path(recordings) / "real" / "calib2d_mapir";
    if (auto drive = from_files("real/calib2d_mapir", folder / "laser.txt", folder / "camera.txt")) {
      drives.push_back(std::move(*drive));
    }
  } else {
    fmt::print(stderr, "SLAMFUSE_RECORDINGS is not set: without real/calib2d_mapir\n");
  }
  for (int i = 1; i + 1 < argc; i += 2) {
    if (auto drive = from_files(argv[i + 1], argv[i], argv[i + 1])) drives.push_back(std::move(*drive));
  }
  drives.push_back(synthetic("synthetic, 2 cm noise", 0.02, 0.0, 2.0, 2.0));
  drives.push_back(synthetic("synthetic, 2 cm noise, scale 2.0 x 2.2", 0.02, 0.0, 2.0, 2.2));
  drives.push_back(synthetic("synthetic, 2 cm noise, scale 2.0 x 2.2, 20 % outliers", 0.02, 0.2, 2.0, 2.2));

  for (const Drive& drive : drives) {
    fmt::print("\n{}\n\n", drive.name);
    fmt::print(
        "| method | verdict | rotation deg | scale x y | rmse cm | held-out cm | all pairs cm | runner-up | "
        "error of angle, scales | ms |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (const Variant& variant : variants()) print_row(variant, drive);
  }
  return 0;
}
