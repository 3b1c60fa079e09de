// SPDX-License-Identifier: BSD-3-Clause
#include "service/dds_publisher.hpp"

#include <map>
#include <string>
#include <utility>

#include "fusion/fused_map.hpp"
#include "fusion/measurement_model.hpp"
#include "service/external_poses.hpp"
#include "service/rate_limit.hpp"
#include "service/ros_conversion.hpp"
#include "service/ros_frames.hpp"
#include "service/thinned_series.hpp"

namespace slamfuse::service {
namespace {

using common::PoseSource;

}  // namespace

struct DdsPublisher::State {
  // A path as far as it was told.
  struct LivePath {
    RateLimit limit;
    std::uint32_t epoch = 0;
    ThinnedSeries<common::StampedPose2> path;
  };

  DdsOptions options;
  CurrentAlignment current_alignment;
  std::shared_ptr<DdsOutputs> outputs;
  std::map<PoseSource, LivePath> paths = {};
  RateLimit map_limit;
  std::map<PoseSource, fusion::StatusEntry> latest_status = {};
  common::Nanoseconds newest_stamp = 0;
  std::optional<common::PoseEstimate> corrected = {};  // in the map frame, the newest
  UnsentMessages unsent = {};

  template <class T>
  void send(idl::Writer<T>& writer, const idl::Message<T>& message) {
    unsent.note(writer.write(message));
  }

  void send_path(PoseSource source, common::Nanoseconds stamp, const common::Trajectory2& path) {
    send(outputs->paths.at(source),
         to_ros_path({stamp, kMapFrame}, path, static_cast<std::size_t>(options.path_poses)));
  }

  void extend_path(const common::PoseEstimate& estimate) {
    LivePath& live = paths.at(estimate.source);
    if (estimate.map_epoch != live.epoch) live.path.clear();  // poses of different epochs never mix
    live.epoch = estimate.map_epoch;
    live.path.push({estimate.stamp, estimate.pose});
  }
};

DdsPublisher::DdsPublisher(std::shared_ptr<DdsOutputs> outputs, const DdsOptions& options,
                           CurrentAlignment current_alignment)
    : state_(std::make_unique<State>(State{.options = options,
                                           .current_alignment = std::move(current_alignment),
                                           .outputs = std::move(outputs),
                                           .map_limit = RateLimit(options.map_period)})) {
  const std::size_t kept = 2 * static_cast<std::size_t>(options.path_poses);  // thinned again when sent
  for (const auto& [source, writer] : state_->outputs->paths) {
    state_->paths.emplace(
        source, State::LivePath{RateLimit(options.path_period), 0, ThinnedSeries<common::StampedPose2>(kept)});
  }
}

DdsPublisher::~DdsPublisher() = default;

void DdsPublisher::on_estimate(const common::PoseEstimate& estimate) {
  if (estimate.state == common::TrackingState::kLost) return;
  state_->newest_stamp = estimate.stamp;
  state_->extend_path(estimate);
  State::LivePath& live = state_->paths.at(estimate.source);
  if (estimate.source == PoseSource::kLaser) {
    if (live.limit.due()) state_->send_path(PoseSource::kLaser, estimate.stamp, live.path.items());
    return;
  }
  const auto alignment = state_->current_alignment();
  if (!alignment || !alignment->accepted || !live.limit.due()) return;
  state_->send_path(PoseSource::kVisual, estimate.stamp, fusion::to_laser_frame(live.path.items(), *alignment));
}

void DdsPublisher::on_corrected_pose(const fusion::CorrectedPose& pose) {
  const common::PoseEstimate& estimate = pose.estimate;
  // tf listeners ignore a stamp that repeats, with a warning, and other systems refuse one that steps back.
  if (state_->corrected && estimate.stamp <= state_->corrected->stamp) return;
  state_->corrected = estimate;
  state_->newest_stamp = estimate.stamp;
  const RosHeader header{estimate.stamp, kMapFrame};
  state_->send(state_->outputs->pose, to_ros_pose(header, estimate.pose, estimate.covariance));
  if (auto& transform = state_->outputs->transform) {
    state_->send(*transform, to_ros_transform(header, kOdomFrame, pose.T_map_odom));
  }
  state_->extend_path(estimate);
  State::LivePath& live = state_->paths.at(PoseSource::kFused);
  if (live.limit.due()) state_->send_path(PoseSource::kFused, estimate.stamp, live.path.items());
}

void DdsPublisher::on_event(const common::Event& event) {
  if (event.kind != kRestarted || !state_->corrected) return;
  const common::SetPose here{state_->corrected->pose, state_->corrected->covariance};
  if (event.module == common::to_string(PoseSource::kLaser)) return on_command(PoseSource::kLaser, here);
  const auto alignment = state_->current_alignment();
  if (!alignment || !alignment->accepted) return;
  const auto visual = fusion::visual_pose({here.pose, here.covariance}, *alignment);
  on_command(PoseSource::kVisual, common::SetPose{visual.pose, visual.covariance});
}

void DdsPublisher::on_command(PoseSource target, const common::Command& command) {
  const auto told = state_->outputs->initial_poses.find(target);
  const auto* set_pose = std::get_if<common::SetPose>(&command);
  if (told == state_->outputs->initial_poses.end() || set_pose == nullptr) return;
  state_->send(told->second, to_ros_pose({state_->newest_stamp, kMapFrame}, set_pose->pose, set_pose->covariance));
}

void DdsPublisher::on_status(const fusion::StatusEntry& status) {
  state_->latest_status[status.source] = status;
  std::vector<fusion::StatusEntry> latest;
  for (const auto& [source, entry] : state_->latest_status) latest.push_back(entry);
  state_->send(state_->outputs->status, to_ros_status({status.stamp, kMapFrame}, latest));
}

void DdsPublisher::on_checkpoint(PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) {
  if (source != PoseSource::kVisual || checkpoint->landmarks.empty()) return;
  const auto alignment = state_->current_alignment();
  if (!alignment || !alignment->accepted) return;
  const auto landmarks = fusion::to_laser_frame(checkpoint->landmarks, *alignment);
  state_->send(state_->outputs->landmarks, to_ros_cloud({state_->newest_stamp, kMapFrame}, landmarks));
}

void DdsPublisher::on_map(common::Nanoseconds stamp, const std::shared_ptr<const common::OccupancyGrid>& map) {
  if (map && state_->map_limit.due()) state_->send(state_->outputs->map, to_ros_grid({stamp, kMapFrame}, *map));
}

void DdsPublisher::finish(const DdsFinalState& final_state) {
  const RosHeader header{state_->newest_stamp, kMapFrame};
  if (final_state.map) state_->send(state_->outputs->map, to_ros_grid(header, *final_state.map));
  const std::pair<PoseSource, const common::Trajectory2&> paths[] = {{PoseSource::kLaser, final_state.laser},
                                                                     {PoseSource::kVisual, final_state.visual},
                                                                     {PoseSource::kFused, final_state.fused}};
  for (const auto& [source, path] : paths) {
    if (!path.empty()) state_->send_path(source, header.stamp, path);
  }
  if (!final_state.landmarks.empty()) {
    state_->send(state_->outputs->landmarks, to_ros_cloud(header, final_state.landmarks));
  }
}

const UnsentMessages& DdsPublisher::unsent() const { return state_->unsent; }

}  // namespace slamfuse::service
