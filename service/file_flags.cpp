// SPDX-License-Identifier: BSD-3-Clause
#include "service/file_flags.hpp"

#include <utility>

#include "common/config.hpp"
#include "service/flag_values.hpp"

namespace slamfuse::service {

using common::Result;

AlignFlags::AlignFlags(CLI::App& app)
    : command_(app.add_subcommand("align", "Align the trajectories of any two SLAM systems")) {
  command_->add_option("LASER", request_.laser, "Trajectory in metres (TUM or `t x y theta`)")->required();
  command_->add_option("VISUAL", request_.visual, "Trajectory of any scale (TUM or `t x y theta`)")->required();
  command_->add_option("-o,--out", request_.out, "Folder for the results")->required();
  command_->add_option("--method", method_, "rigid, similarity, affine, seed004 or auto");
  command_->add_option("--seed", request_.seed, "Seed of everything random")
      ->check(whole_number())
      ->capture_default_str();
  configuration_.add_to(*command_);
}

Result<CommandRequest> AlignFlags::request() {
  if (!method_.empty()) configuration_.settings.push_back("fusion.alignment.method=" + method_);
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  request_.options = configuration->fusion.alignment;
  return request_;
}

EvaluateFlags::EvaluateFlags(CLI::App& app)
    : command_(app.add_subcommand("evaluate", "Compare a trajectory with a reference")) {
  command_->add_option("ESTIMATE", request_.estimate, "Trajectory of base_link (TUM or `t x y theta`)")->required();
  command_->add_option("REFERENCE", reference_,
                       "Trajectory, recording with ground truth, or reference of a corrected CARMEN log");
  command_->add_option("--align", align_, "How the estimate is fitted first")
      ->check(CLI::IsMember({"se2", "sim2", "none"}))
      ->capture_default_str();
  command_->add_option("--align-as", align_as_, "EST REF: apply the transform fitted on this pair instead")
      ->expected(2);
  command_->add_option("--relations", relations_, "Relations file: the metric of Kuemmerle et al. 2009");
  command_->add_flag("--fit-offset", request_.fit_offset,
                     "The reference is of another body on the robot, by another clock (motion capture): fit one "
                     "constant offset of each as well");
  recording_.add_to(*command_);
  command_->add_flag("--json", request_.json, "Print JSON");
}

Result<CommandRequest> EvaluateFlags::request() {
  if (reference_.empty() && relations_.empty()) {
    return common::usage_error("evaluate: give a REFERENCE, or --relations, or both");
  }
  if (!align_as_.empty() && reference_.empty()) return common::usage_error("--align-as: needs a REFERENCE");
  if (!align_as_.empty() && align_ == "none") {
    return common::usage_error("--align none: with --align-as only se2 or sim2, which say how that pair is fitted");
  }
  if (request_.fit_offset && (align_ != "se2" || !align_as_.empty())) {
    return common::usage_error("--fit-offset: only with --align se2 and without --align-as");
  }
  auto recording = recording_.read();
  if (!recording) return tl::unexpected(recording.error());
  request_.recording_options = std::move(*recording);
  if (!reference_.empty()) request_.reference = reference_;
  if (!relations_.empty()) request_.relations = relations_;
  if (!align_as_.empty()) request_.align_as = {align_as_[0], align_as_[1]};
  using common::EvaluationAlignment;
  request_.align = align_ == "sim2"   ? EvaluationAlignment::kSim2
                   : align_ == "none" ? EvaluationAlignment::kNone
                                      : EvaluationAlignment::kSe2;
  return request_;
}

InfoFlags::InfoFlags(CLI::App& app)
    : command_(app.add_subcommand("info", "What is in a recording or in a map bundle")) {
  command_->add_option("PATH", request_.path, "Recording or map bundle")->required();
  recording_.add_to(*command_);
}

Result<CommandRequest> InfoFlags::request() const {
  auto recording = recording_.read();
  if (!recording) return tl::unexpected(recording.error());
  InfoRequest request = request_;
  request.recording_options = std::move(*recording);
  return request;
}

OptionsFlags::OptionsFlags(CLI::App& app)
    : command_(app.add_subcommand("options", "Print every option with its default, unit, range and meaning")) {
  command_->add_option("--format", format_, "yaml: a file for --config; markdown: tables; text")
      ->check(CLI::IsMember({"yaml", "markdown", "text"}))
      ->capture_default_str();
  configuration_.add_to(*command_);
}

Result<CommandRequest> OptionsFlags::request() const {
  auto configuration = configuration_.read();
  if (!configuration) return tl::unexpected(configuration.error());
  const auto describe = [&](common::OptionVisitor& visit) { configuration->describe(visit); };
  if (format_ == "markdown") return PrintRequest{common::options_to_markdown(describe)};
  if (format_ == "text") return PrintRequest{common::options_to_help(describe)};
  return PrintRequest{common::options_to_yaml(describe)};
}

}  // namespace slamfuse::service
