// SPDX-License-Identifier: BSD-3-Clause
#include "service/dds_publisher.hpp"

#include <map>
#include <string>
#include <utility>

#include "fusion/fused_map.hpp"
#include "idl/writer.hpp"
#include "service/deadline.hpp"
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
    idl::Writer<idl::Path> writer;
    RateLimit limit;
    std::uint32_t epoch = 0;
    ThinnedSeries<common::StampedPose2> path;
  };

  DdsOptions options;
  CurrentAlignment current_alignment;
  idl::Participant participant;
  idl::Writer<idl::PoseWithCovarianceStamped> pose;
  idl::Writer<idl::TFMessage> transform;
  idl::Writer<idl::OccupancyGrid> map;
  idl::Writer<idl::PointCloud2> landmarks;
  idl::Writer<idl::FusionStatus> status;
  std::map<PoseSource, LivePath> paths = {};
  RateLimit map_limit;
  std::map<PoseSource, fusion::StatusEntry> latest_status = {};
  common::Nanoseconds newest_stamp = 0;
  UnsentMessages unsent = {};

  template <class T>
  void send(idl::Writer<T>& writer, const idl::Message<T>& message) {
    unsent.note(writer.write(message));
  }

  void send_path(PoseSource source, common::Nanoseconds stamp, const common::Trajectory2& path) {
    send(paths.at(source).writer, to_ros_path({stamp, kMapFrame}, path, static_cast<std::size_t>(options.path_poses)));
  }

  void extend_path(const common::PoseEstimate& estimate) {
    LivePath& live = paths.at(estimate.source);
    if (estimate.map_epoch != live.epoch) live.path.clear();  // poses of different epochs never mix
    live.epoch = estimate.map_epoch;
    live.path.push({estimate.stamp, estimate.pose});
  }

  template <class Wait>
  void for_each_writer(const Wait& wait) const {
    wait(pose);
    wait(transform);
    wait(map);
    wait(landmarks);
    wait(status);
    for (const auto& [source, live] : paths) wait(live.writer);
  }
};

common::Result<std::unique_ptr<DdsPublisher>> DdsPublisher::create(const idl::Participant& participant,
                                                                   const DdsOptions& options,
                                                                   CurrentAlignment current_alignment) {
  auto pose =
      idl::Writer<idl::PoseWithCovarianceStamped>::create(participant, "slamfuse/pose", idl::QosProfile::kOutput);
  if (!pose) return tl::unexpected(pose.error());
  auto transform = idl::Writer<idl::TFMessage>::create(participant, "tf", idl::QosProfile::kOutput);
  if (!transform) return tl::unexpected(transform.error());
  auto map = idl::Writer<idl::OccupancyGrid>::create(participant, "map", idl::QosProfile::kLatchedOutput);
  if (!map) return tl::unexpected(map.error());
  auto landmarks = idl::Writer<idl::PointCloud2>::create(participant, "slamfuse/landmarks", idl::QosProfile::kOutput);
  if (!landmarks) return tl::unexpected(landmarks.error());
  auto status = idl::Writer<idl::FusionStatus>::create(participant, "slamfuse/status", idl::QosProfile::kOutput);
  if (!status) return tl::unexpected(status.error());

  auto state = std::make_unique<State>(State{.options = options,
                                             .current_alignment = std::move(current_alignment),
                                             .participant = participant,
                                             .pose = *std::move(pose),
                                             .transform = *std::move(transform),
                                             .map = *std::move(map),
                                             .landmarks = *std::move(landmarks),
                                             .status = *std::move(status),
                                             .map_limit = RateLimit(options.map_period)});
  const std::size_t kept = 2 * static_cast<std::size_t>(options.path_poses);  // thinned again when sent
  for (const PoseSource source : {PoseSource::kLaser, PoseSource::kVisual, PoseSource::kFused}) {
    auto path = idl::Writer<idl::Path>::create(participant, "slamfuse/path/" + common::to_string(source),
                                               idl::QosProfile::kOutput);
    if (!path) return tl::unexpected(path.error());
    state->paths.emplace(source, State::LivePath{*std::move(path), RateLimit(options.path_period), 0,
                                                 ThinnedSeries<common::StampedPose2>(kept)});
  }

  const Deadline deadline(options.reader_wait);
  state->pose.wait_for_reader(deadline.left());
  state->transform.wait_for_reader(deadline.left());
  return std::unique_ptr<DdsPublisher>(new DdsPublisher(std::move(state)));
}

DdsPublisher::DdsPublisher(std::unique_ptr<State> state) : state_(std::move(state)) {}
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
  state_->newest_stamp = estimate.stamp;
  const RosHeader header{estimate.stamp, kMapFrame};
  state_->send(state_->pose, to_ros_pose(header, estimate.pose, estimate.covariance));
  state_->send(state_->transform, to_ros_transform(header, kOdomFrame, pose.T_map_odom));
  state_->extend_path(estimate);
  State::LivePath& live = state_->paths.at(PoseSource::kFused);
  if (live.limit.due()) state_->send_path(PoseSource::kFused, estimate.stamp, live.path.items());
}

void DdsPublisher::on_status(const fusion::StatusEntry& status) {
  state_->latest_status[status.source] = status;
  std::vector<fusion::StatusEntry> latest;
  for (const auto& [source, entry] : state_->latest_status) latest.push_back(entry);
  state_->send(state_->status, to_ros_status({status.stamp, kMapFrame}, latest));
}

void DdsPublisher::on_checkpoint(PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) {
  if (source != PoseSource::kVisual || checkpoint->landmarks.empty()) return;
  const auto alignment = state_->current_alignment();
  if (!alignment || !alignment->accepted) return;
  const auto landmarks = fusion::to_laser_frame(checkpoint->landmarks, *alignment);
  state_->send(state_->landmarks, to_ros_cloud({state_->newest_stamp, kMapFrame}, landmarks));
}

void DdsPublisher::on_map(common::Nanoseconds stamp, const std::shared_ptr<const common::OccupancyGrid>& map) {
  if (map && state_->map_limit.due()) state_->send(state_->map, to_ros_grid({stamp, kMapFrame}, *map));
}

double DdsPublisher::linger() const { return state_->options.linger; }

void DdsPublisher::finish(const DdsFinalState& final_state, double patience) {
  const RosHeader header{state_->newest_stamp, kMapFrame};
  if (final_state.map) state_->send(state_->map, to_ros_grid(header, *final_state.map));
  const std::pair<PoseSource, const common::Trajectory2&> paths[] = {{PoseSource::kLaser, final_state.laser},
                                                                     {PoseSource::kVisual, final_state.visual},
                                                                     {PoseSource::kFused, final_state.fused}};
  for (const auto& [source, path] : paths) {
    if (!path.empty()) state_->send_path(source, header.stamp, path);
  }
  if (!final_state.landmarks.empty()) {
    state_->send(state_->landmarks, to_ros_cloud(header, final_state.landmarks));
  }
  const Deadline deadline(patience);
  state_->for_each_writer([&](const auto& writer) { writer.wait_for_acknowledgments(deadline.left()); });
}

const UnsentMessages& DdsPublisher::unsent() const { return state_->unsent; }

}  // namespace slamfuse::service
