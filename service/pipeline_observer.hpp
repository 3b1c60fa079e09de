// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/command.hpp"
#include "common/occupancy_grid.hpp"
#include "common/pose_estimate.hpp"
#include "common/sensor_message.hpp"
#include "fusion/fusion.hpp"
#include "service/module_checkpoint.hpp"

namespace slamfuse::service {

/// Watches a running pipeline: the recorder of the output files, the DDS publisher, the progress line. All calls come
/// from one thread at a time, in an order that does not depend on the number of threads. An observer must not take
/// long: the pipeline waits for it.
class PipelineObserver {
 public:
  virtual ~PipelineObserver() = default;
  /// Everything made from the inputs up to this stamp has been told.
  virtual void on_step(common::Nanoseconds /*stamp*/) {}
  virtual void on_odometry(const common::WheelOdometry& /*odometry*/) {}
  /// From the laser or the visual module, whatever its state.
  virtual void on_estimate(const common::PoseEstimate& /*estimate*/) {}
  virtual void on_corrected_pose(const fusion::CorrectedPose& /*pose*/) {}
  virtual void on_status(const fusion::StatusEntry& /*status*/) {}
  /// Asked of a module by the fusion or an operator; told when it is issued.
  virtual void on_command(common::PoseSource /*target*/, const common::Command& /*command*/) {}
  virtual void on_event(const common::Event& /*event*/) {}
  /// A message of this sensor did not reach its module, which was busy; see PipelineOptions::live_backlog.
  virtual void on_dropped(const std::string& /*sensor*/) {}
  /// What a module knows now, every PipelineOptions::checkpoint_interval.
  virtual void on_checkpoint(common::PoseSource /*source*/,
                             const std::shared_ptr<const ModuleCheckpoint>& /*checkpoint*/) {}
  /// The laser map as it is now; every PipelineOptions::map_interval when a map source was given.
  virtual void on_map(common::Nanoseconds /*stamp*/, const std::shared_ptr<const common::OccupancyGrid>& /*map*/) {}
};

/// Several observers as one, told in the order given.
class ObserverList : public PipelineObserver {
 public:
  void add(PipelineObserver& observer) { observers_.push_back(&observer); }

  void on_step(common::Nanoseconds stamp) override {
    for (auto* observer : observers_) observer->on_step(stamp);
  }
  void on_odometry(const common::WheelOdometry& odometry) override {
    for (auto* observer : observers_) observer->on_odometry(odometry);
  }
  void on_estimate(const common::PoseEstimate& estimate) override {
    for (auto* observer : observers_) observer->on_estimate(estimate);
  }
  void on_corrected_pose(const fusion::CorrectedPose& pose) override {
    for (auto* observer : observers_) observer->on_corrected_pose(pose);
  }
  void on_status(const fusion::StatusEntry& status) override {
    for (auto* observer : observers_) observer->on_status(status);
  }
  void on_command(common::PoseSource target, const common::Command& command) override {
    for (auto* observer : observers_) observer->on_command(target, command);
  }
  void on_event(const common::Event& event) override {
    for (auto* observer : observers_) observer->on_event(event);
  }
  void on_dropped(const std::string& sensor) override {
    for (auto* observer : observers_) observer->on_dropped(sensor);
  }
  void on_map(common::Nanoseconds stamp, const std::shared_ptr<const common::OccupancyGrid>& map) override {
    for (auto* observer : observers_) observer->on_map(stamp, map);
  }
  void on_checkpoint(common::PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) override {
    for (auto* observer : observers_) observer->on_checkpoint(source, checkpoint);
  }

 private:
  std::vector<PipelineObserver*> observers_;
};

}  // namespace slamfuse::service
