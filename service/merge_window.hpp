// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "common/occupancy_grid.hpp"
#include "common/pose2.hpp"
#include "common/pose_estimate.hpp"
#include "common/recording.hpp"
#include "common/sensor_message.hpp"
#include "service/module_checkpoint.hpp"

namespace slamfuse::service {

/// The place of an input in arrival order, from 0. Everything that must not depend on thread timing refers to it.
using SequenceIndex = std::int64_t;

/// An input on its way to the modules.
struct NumberedMessage {
  SequenceIndex index = 0;
  common::SensorMessage message;
  std::optional<common::Pose2> T_odom_base;  ///< of the newest wheel odometry up to this input
};

/// What a module made of one input.
struct ModuleOutput {
  std::optional<common::PoseEstimate> estimate;
  std::optional<common::RejectedMessage> rejected;
  std::shared_ptr<const common::OccupancyGrid> map;    ///< a picture of its map, now and then
  std::shared_ptr<const ModuleCheckpoint> checkpoint;  ///< now and then
};

/// One input and all that the modules made of it: what the fusion handles in one go.
struct MergedStep {
  SequenceIndex index = 0;
  common::Nanoseconds stamp = 0;
  std::optional<common::Pose2> T_odom_base;  ///< of the newest wheel odometry up to this input
  std::optional<common::WheelOdometry> odometry;
  std::optional<common::RejectedMessage> rejected;     ///< by the reader
  std::optional<std::string> dropped_of;               ///< the sensor whose message a busy module did not get
  std::map<common::PoseSource, ModuleOutput> outputs;  ///< in the order of PoseSource
};

/// In which order steps are taken.
enum class MergeOrder {
  kByIndex,     ///< a replay: always the same
  kAsComplete,  ///< live: the first that is complete, so that a slow module holds up nobody else's poses
};

/// Gathers what modules that run at their own pace made of each input (DESIGN section 3).
///
/// The reader opens a slot for every input, naming the modules that get it; each module completes its part; the fusion
/// takes slots that no module owes anything for any more. The number of open slots is bounded: the reader waits. In a
/// replay slots are taken in index order, so that the fusion sees outputs sorted by (index, source) however the threads
/// ran. Live, a slot is taken as soon as it is complete, even when steps before it still wait for a slow module, so
/// that one holds up the reader only when it owes as many outputs as there are slots.
class MergeWindow {
 public:
  explicit MergeWindow(std::size_t capacity, MergeOrder order = MergeOrder::kByIndex)
      : capacity_(capacity), order_(order) {}

  /// Reader: adds a step (indices must rise) that `owed_by` still have to complete. Waits for room. Returns
  /// false after abort().
  bool open(MergedStep step, std::set<common::PoseSource> owed_by);
  /// Module: its part of step `index` is done. Nothing happens when the step did not wait for it.
  void complete(SequenceIndex index, common::PoseSource source, ModuleOutput output);
  /// Fusion: the next step in the order wanted, waiting until it is complete. Empty after close() when all were taken,
  /// or after abort().
  std::optional<MergedStep> take();

  /// Reader: no more steps will be opened.
  void close();
  /// Wakes everybody up and forgets what is inside.
  void abort();

 private:
  struct Slot {
    MergedStep step;
    std::set<common::PoseSource> owed_by;
  };
  using Slots = std::map<SequenceIndex, Slot>;

  /// The slot to take next, if it is complete.
  Slots::iterator next_slot();

  const std::size_t capacity_;
  const MergeOrder order_;
  std::mutex mutex_;
  std::condition_variable room_;
  std::condition_variable ready_;
  Slots slots_;
  bool closed_ = false;
  bool aborted_ = false;
};

}  // namespace slamfuse::service
