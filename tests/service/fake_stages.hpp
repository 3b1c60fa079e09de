// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "common/slam_module.hpp"
#include "service/fusion_stage.hpp"
#include "service/pipeline_observer.hpp"

namespace slamfuse::service {

/// A module that writes down what is done to it; each pose's x is the number of calls so far, so a misplaced command
/// shows in every later pose.
class FakeModule : public common::SlamModule {
 public:
  FakeModule(
      common::PoseSource source, std::function<void()> delay = [] {})
      : source_(source), delay_(std::move(delay)) {}

  common::PoseSource source() const override { return source_; }
  bool wants(const common::SensorMessage& message) const override {
    return std::holds_alternative<common::WheelOdometry>(message) ||
           (source_ == common::PoseSource::kLaser ? std::holds_alternative<common::LaserScan>(message)
                                                  : std::holds_alternative<common::Image>(message));
  }
  common::ProcessResult process(const common::SensorMessage& message) override {
    delay_();
    const common::Nanoseconds stamp = common::stamp_of(message);
    calls.push_back(fmt::format("process {}", stamp));
    if (throw_at == stamp) throw std::runtime_error("the fake module threw");
    if (std::holds_alternative<common::WheelOdometry>(message)) return {};
    if (reject_from > 0 && stamp >= reject_from) return {std::nullopt, "value 7 is not allowed"};
    common::PoseEstimate estimate;
    estimate.stamp = stamp;
    estimate.source = source_;
    estimate.pose.x = static_cast<double>(calls.size());
    return {estimate, std::nullopt};
  }
  void execute(const common::Command& command) override {
    const auto* set_pose = std::get_if<common::SetPose>(&command);
    calls.push_back(set_pose != nullptr ? fmt::format("set pose {:.3f}", set_pose->pose.x) : "command");
  }
  common::Trajectory2 final_trajectory() const override { return {}; }

  std::vector<std::string> calls;
  common::Nanoseconds throw_at = 0;
  common::Nanoseconds reject_from = 0;

 private:
  common::PoseSource source_;
  std::function<void()> delay_;
};

/// Echoes every estimate as a corrected pose; after every `command_every`-th input it commands both modules.
class FakeFusion : public FusionStage {
 public:
  explicit FakeFusion(int command_every = 0) : command_every_(command_every) {}
  fusion::FusionOutput process(const common::WheelOdometry&) override { return answer(std::nullopt); }
  fusion::FusionOutput process(const common::PoseEstimate& estimate) override { return answer(estimate); }
  fusion::FusionOutput align_now() override { return {}; }
  const std::optional<fusion::Alignment>& alignment() const override { return alignment_; }
  void align(const fusion::Alignment& alignment) { alignment_ = alignment; }

 private:
  fusion::FusionOutput answer(const std::optional<common::PoseEstimate>& estimate) {
    fusion::FusionOutput output;
    if (estimate) {
      output.pose.emplace();
      output.pose->estimate = *estimate;
    }
    if (command_every_ > 0 && ++inputs_ % command_every_ == 0) {
      output.commands.push_back({common::PoseSource::kLaser, common::SetPose{{100.0, 0.0, 0.0}}});
      output.commands.push_back({common::PoseSource::kVisual, common::Relocalise{}});
    }
    return output;
  }
  int command_every_;
  int inputs_ = 0;
  std::optional<fusion::Alignment> alignment_;
};

/// Everything the pipeline told, as text in order.
class Transcript : public PipelineObserver {
 public:
  void on_step(common::Nanoseconds stamp) override { lines.push_back(fmt::format("step {}", stamp)); }
  void on_odometry(const common::WheelOdometry& odometry) override {
    lines.push_back(fmt::format("odometry {}", odometry.stamp));
  }
  void on_estimate(const common::PoseEstimate& estimate) override {
    lines.push_back(fmt::format("{} {} {}", common::to_string(estimate.source), estimate.stamp, estimate.pose.x));
  }
  void on_corrected_pose(const fusion::CorrectedPose& pose) override {
    lines.push_back(fmt::format("fused {} {}", pose.estimate.stamp, pose.estimate.pose.x));
  }
  void on_command(common::PoseSource target, const common::Command& command) override {
    commands.emplace_back(target, command);
  }
  void on_event(const common::Event& event) override {
    events.push_back(event);
    lines.push_back(event.kind + " " + event.detail);
  }
  std::vector<std::string> lines;
  std::vector<common::Event> events;
  std::vector<std::pair<common::PoseSource, common::Command>> commands;
};

/// Sleeps up to `most`, differently each time.
inline std::function<void()> random_delay(unsigned seed, std::chrono::microseconds most) {
  return [generator = std::mt19937(seed), most]() mutable {
    std::this_thread::sleep_for(most * (generator() % 100) / 100);
  };
}

}  // namespace slamfuse::service
