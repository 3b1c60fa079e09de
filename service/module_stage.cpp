// SPDX-License-Identifier: BSD-3-Clause
#include "service/module_stage.hpp"

#include <chrono>
#include <variant>

namespace slamfuse::service {
namespace {

using Clock = std::chrono::steady_clock;

bool is_exteroceptive(const common::SensorMessage& message) {
  return std::holds_alternative<common::LaserScan>(message) || std::holds_alternative<common::Image>(message);
}

}  // namespace

ModuleOutput ModuleStage::process(const NumberedMessage& input, const std::vector<common::Command>& commands) {
  for (const auto& command : commands) module_.module->execute(command);

  const common::Nanoseconds stamp = common::stamp_of(input.message);
  const auto start = Clock::now();
  const common::ProcessResult result = module_.module->process(input.message);
  const std::chrono::duration<double, std::milli> elapsed = Clock::now() - start;

  if (is_exteroceptive(input.message)) {
    ++counters_.inputs;
    counters_.updates.push_back({stamp, elapsed.count()});
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
  }
  return output;
}

std::shared_ptr<const common::OccupancyGrid> ModuleStage::map_if_due(common::Nanoseconds stamp) {
  if (!module_.map || map_interval_ <= 0) return nullptr;
  if (last_map_ && stamp - *last_map_ < map_interval_) return nullptr;
  last_map_ = stamp;
  return std::make_shared<const common::OccupancyGrid>(module_.map());
}

}  // namespace slamfuse::service
