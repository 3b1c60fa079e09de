// SPDX-License-Identifier: BSD-3-Clause
#include "benchmark/visual_messages.hpp"

#include <ctime>
#include <sstream>

#include "common/recording.hpp"

namespace slamfuse {

common::Result<VisualMessages> read_visual_messages(const std::filesystem::path& path, const std::string& cameras) {
  auto recording = common::open_recording(path);
  if (!recording) return tl::unexpected(recording.error());
  VisualMessages read;
  read.first_stamp = (*recording)->info().first_stamp;
  const auto& known = (*recording)->info().calibration.cameras;
  std::istringstream names(cameras);
  for (std::string name; std::getline(names, name, ',');) {
    if (!known.contains(name)) return common::usage_error("the recording has no camera " + name);
    read.cameras.emplace(name, known.at(name));
  }
  while (true) {
    auto item = (*recording)->next();
    if (!item) return tl::unexpected(item.error());
    if (!*item) return read;
    const auto* message = std::get_if<common::SensorMessage>(&**item);
    if (message == nullptr) continue;
    const auto* image = std::get_if<common::Image>(message);
    if (image != nullptr ? read.cameras.contains(image->sensor)
                         : std::holds_alternative<common::WheelOdometry>(*message)) {
      read.messages.push_back(*message);
    }
  }
}

double processor_milliseconds() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace slamfuse
