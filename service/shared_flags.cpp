// SPDX-License-Identifier: BSD-3-Clause
#include "service/shared_flags.hpp"

#include <utility>

#include <fmt/format.h>

#include "common/config.hpp"

namespace slamfuse::service {

using common::Result;

void ConfigurationFlags::add_to(CLI::App& command) {
  command.add_option("--config", file, "YAML file with options; `slamfuse options` prints them all");
  command.add_option("--set", settings, "One option, after --config: KEY=VALUE, e.g. laser.particles=50; repeatable")
      ->allow_extra_args(false);
}

Result<Configuration> ConfigurationFlags::read() const {
  Configuration configuration;
  const auto describe = [&configuration](common::OptionVisitor& visit) { configuration.describe(visit); };
  if (!file.empty()) {
    if (auto done = common::read_options(file, describe); !done) return tl::unexpected(done.error());
  }
  for (const auto& setting : settings) {
    if (auto done = common::set_option(setting, describe); !done) return tl::unexpected(done.error());
  }
  return configuration;
}

void RecordingFlags::add_to(CLI::App& command) {
  command
      .add_option("--topic", topics,
                  "SENSOR=TOPIC of a ROS bag or of the robot, e.g. laser0=/front/scan, odom0=/tf, truth=/mocap/pose; "
                  "`none` leaves "
                  "it out; repeatable")
      ->allow_extra_args(false);
  command.add_option("--base-frame", base_frame, "Frame of the robot (default: base_link or, in a bag, alike)");
}

Result<common::RecordingOptions> RecordingFlags::read() const {
  common::RecordingOptions options;
  options.base_frame = base_frame;
  for (const auto& text : topics) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
      return common::usage_error(fmt::format("--topic {}: must be SENSOR=TOPIC", text));
    }
    if (!options.topics.emplace(text.substr(0, equals), text.substr(equals + 1)).second) {
      return common::usage_error(fmt::format("--topic {}: the sensor was given twice", text));
    }
  }
  return options;
}

}  // namespace slamfuse::service
