// SPDX-License-Identifier: BSD-3-Clause
#include "service/dds_outputs.hpp"

#include <string>
#include <utility>

#include "service/deadline.hpp"

namespace slamfuse::service {

using common::PoseSource;

common::Result<idl::RosNamespace> namespace_of(const DdsOptions& options) {
  return idl::RosNamespace::create(options.name_space).map_error([](common::Error error) {
    error.message = "service.dds.namespace: " + error.message;
    return error;
  });
}

common::Result<std::shared_ptr<DdsOutputs>> DdsOutputs::create(const idl::Participant& participant,
                                                               const idl::RosNamespace& names, bool publish_tf) {
  constexpr auto kOutput = idl::QosProfile::kOutput;
  auto pose = idl::Writer<idl::PoseWithCovarianceStamped>::create(participant, names.resolve("slamfuse/pose"), kOutput);
  if (!pose) return tl::unexpected(pose.error());
  std::optional<idl::Writer<idl::TFMessage>> transform;
  if (publish_tf) {
    auto made = idl::Writer<idl::TFMessage>::create(participant, names.resolve("/tf"), kOutput);
    if (!made) return tl::unexpected(made.error());
    transform = *std::move(made);
  }
  auto map =
      idl::Writer<idl::OccupancyGrid>::create(participant, names.resolve("map"), idl::QosProfile::kLatchedOutput);
  if (!map) return tl::unexpected(map.error());
  auto landmarks = idl::Writer<idl::PointCloud2>::create(participant, names.resolve("slamfuse/landmarks"), kOutput);
  if (!landmarks) return tl::unexpected(landmarks.error());
  auto status = idl::Writer<idl::FusionStatus>::create(participant, names.resolve("slamfuse/status"), kOutput);
  if (!status) return tl::unexpected(status.error());

  auto outputs = std::make_shared<DdsOutputs>(
      DdsOutputs{*std::move(pose), std::move(transform), *std::move(map), *std::move(landmarks), *std::move(status)});
  for (const PoseSource source : {PoseSource::kLaser, PoseSource::kVisual, PoseSource::kFused}) {
    auto path = idl::Writer<idl::Path>::create(participant, names.resolve("slamfuse/path/" + common::to_string(source)),
                                               kOutput);
    if (!path) return tl::unexpected(path.error());
    outputs->paths.emplace(source, *std::move(path));
  }
  return outputs;
}

common::Result<void> DdsOutputs::add_initial_pose(const idl::Participant& participant, PoseSource half,
                                                  const std::string& topic) {
  if (topic.empty()) return {};
  auto writer = idl::Writer<idl::PoseWithCovarianceStamped>::create(participant, idl::RosNamespace().resolve(topic),
                                                                    idl::QosProfile::kOutput);
  if (!writer) return tl::unexpected(writer.error());
  initial_poses.emplace(half, *std::move(writer));
  return {};
}

void DdsOutputs::wait_for_listeners(double seconds) const {
  const Deadline deadline(seconds);
  pose.wait_for_reader(deadline.left());
  if (transform) transform->wait_for_reader(deadline.left());
}

void DdsOutputs::wait_for_acknowledgments(double seconds) const {
  const Deadline deadline(seconds);
  pose.wait_for_acknowledgments(deadline.left());
  if (transform) transform->wait_for_acknowledgments(deadline.left());
  map.wait_for_acknowledgments(deadline.left());
  landmarks.wait_for_acknowledgments(deadline.left());
  status.wait_for_acknowledgments(deadline.left());
  for (const auto& [source, path] : paths) path.wait_for_acknowledgments(deadline.left());
}

}  // namespace slamfuse::service
