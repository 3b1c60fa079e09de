// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "common/recording.hpp"

namespace slamfuse::service {

/// A recording from memory.
class FakeRecording : public common::Recording {
 public:
  explicit FakeRecording(std::vector<common::RecordingItem> items) : items_(std::move(items)) {
    info_.sensors["laser0"].kind = common::SensorKind::kLaser;
    info_.sensors["cam0"].kind = common::SensorKind::kCamera;
    info_.sensors["odom0"].kind = common::SensorKind::kOdometry;
  }
  const common::RecordingInfo& info() const override { return info_; }
  common::Result<std::optional<common::RecordingItem>> next() override {
    if (position_ == items_.size()) return std::optional<common::RecordingItem>();
    return std::optional<common::RecordingItem>(items_[position_++]);
  }

 private:
  common::RecordingInfo info_;
  std::vector<common::RecordingItem> items_;
  std::size_t position_ = 0;
};

/// `count` rounds of one odometry message, one scan and one image, 10 ms apart; the robot drives along x, 1 cm a round.
inline std::vector<common::RecordingItem> rounds(int count) {
  std::vector<common::RecordingItem> items;
  for (int i = 0; i < count; ++i) {
    const common::Nanoseconds stamp = 1'000'000'000LL + i * 30'000'000LL;
    items.emplace_back(common::SensorMessage(common::WheelOdometry{stamp, "odom0", {0.01 * i, 0.0, 0.0}, 0.3, 0.0}));
    items.emplace_back(common::SensorMessage(common::LaserScan{stamp + 10'000'000, "laser0", {1.0F}}));
    items.emplace_back(common::SensorMessage(common::Image{stamp + 20'000'000, "cam0", 0, 0, nullptr}));
  }
  return items;
}

}  // namespace slamfuse::service
