// SPDX-License-Identifier: BSD-3-Clause
#include "service/module_stage.hpp"

#include <chrono>
#include <utility>
#include <variant>

namespace slamfuse::service {
namespace {

using Clock = std::chrono::steady_clock;

/// Whether `interval` has passed since `last`, which then moves on.
bool is_due(common::Nanoseconds interval, common::Nanoseconds stamp, std::optional<common::Nanoseconds>& last) {
  if (interval <= 0 || (last && stamp - *last < interval)) return false;
  last = stamp;
  return true;
}

}  // namespace

bool ModuleStage::is_exteroceptive(const common::SensorMessage& message) {
  return std::holds_alternative<common::LaserScan>(message) || std::holds_alternative<common::Image>(message) ||
         std::holds_alternative<common::ExternalPose>(message);
}

ModuleOutput ModuleStage::process(const NumberedMessage& input, const std::vector<common::Command>& commands) {
  for (const auto& command : commands) module_.module->execute(command);

  const common::Nanoseconds stamp = common::stamp_of(input.message);
  const auto start = Clock::now();
  const common::ProcessResult result = module_.module->process(input.message);
  const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start;

  if (is_exteroceptive(input.message)) {
    ++counters_.inputs;
    counters_.updated({stamp, elapsed.count()});
  }
  ModuleOutput output;
  if (result.rejected) {
    ++counters_.rejected;
    output.rejected = common::RejectedMessage{stamp, common::sensor_of(input.message), *result.rejected};
  }
  if (result.estimate) {
    ++counters_.poses;
    output.estimate = result.estimate;
    output.map = map_if_due(result.estimate->stamp);
    output.checkpoint = checkpoint_if_due(result.estimate->stamp);
  }
  return output;
}

std::shared_ptr<const common::OccupancyGrid> ModuleStage::map_if_due(common::Nanoseconds stamp) {
  if (!module_.map || !is_due(intervals_.map, stamp, last_map_)) return nullptr;
  return std::make_shared<const common::OccupancyGrid>(module_.map());
}

std::shared_ptr<const ModuleCheckpoint> ModuleStage::checkpoint_if_due(common::Nanoseconds stamp) {
  if (!module_.checkpoint) return nullptr;
  if (!last_checkpoint_) last_checkpoint_ = stamp;  // the first moment is not worth saving
  const std::uint32_t wanted = requests_ != nullptr ? requests_->checkpoints_wanted() : 0;
  if (std::exchange(checkpoints_answered_, wanted) != wanted) {
    last_checkpoint_ = stamp;
  } else if (!is_due(intervals_.checkpoint, stamp, last_checkpoint_)) {
    return nullptr;
  }
  return std::make_shared<const ModuleCheckpoint>(module_.checkpoint());
}

}  // namespace slamfuse::service
