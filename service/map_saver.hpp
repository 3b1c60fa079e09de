// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>

#include "common/error.hpp"
#include "fusion/alignment.hpp"
#include "service/module_checkpoint.hpp"
#include "service/pipeline_observer.hpp"
#include "service/thinned_series.hpp"

namespace slamfuse::service {

/// Saves the map bundle of a running service again and again, so that a process that is killed loses at most what came
/// since the last time. Written in a thread of its own, each bundle whole before it takes the place of the one before.
/// The halves' parts may be of slightly different moments; the fused path is the poses as they were told.
class MapSaver : public PipelineObserver {
 public:
  using CurrentAlignment = std::function<std::optional<fusion::Alignment>()>;

  /// Bundles go to the folder `path`, with at most `most_poses` of the fused path. `current_alignment` is asked from
  /// within the observer's calls.
  MapSaver(std::filesystem::path path, std::uint64_t seed, std::string recording, CurrentAlignment current_alignment,
           std::size_t most_poses = ThinnedSeries<int>::kAll);
  /// Waits for the one being written.
  ~MapSaver() override;

  void on_corrected_pose(const fusion::CorrectedPose& pose) override;
  void on_checkpoint(common::PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) override;

  /// Waits until a bundle is written with a newer checkpoint of every half named than it has now; `ask` is called once
  /// that waits. Error (kFailed): none in time, or it could not be written.
  common::Result<void> save_new(const std::set<common::PoseSource>& halves, const std::function<void()>& ask,
                                std::chrono::nanoseconds patience);

  /// Bundles written so far; from any thread, as the next.
  std::size_t saved() const;
  /// Why the last attempt failed; empty when it did not.
  std::optional<common::Error> failure() const;

 private:
  /// How many checkpoints of each half there have been.
  using Count = std::map<common::PoseSource, std::size_t>;

  struct Snapshot {
    Count count;
    std::map<common::PoseSource, std::shared_ptr<const ModuleCheckpoint>> modules;
    std::optional<fusion::Alignment> alignment;
    common::Trajectory2 fused;
  };

  void write_all(const std::stop_token& done);
  common::Result<void> write(const Snapshot& snapshot) const;

  const std::filesystem::path path_;
  const std::uint64_t seed_;
  const std::string recording_;
  CurrentAlignment current_alignment_;

  // of the observer's thread
  std::map<common::PoseSource, std::shared_ptr<const ModuleCheckpoint>> modules_;
  ThinnedSeries<common::StampedPose2> fused_;
  std::uint32_t fused_epoch_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable_any wanted_;
  std::condition_variable_any written_;
  std::optional<Snapshot> next_;
  Count arrived_;
  Count attempted_;  // of the last bundle, written or not
  std::size_t saved_ = 0;
  std::optional<common::Error> failure_;

  std::jthread writer_;  // last: it ends before what it uses
};

}  // namespace slamfuse::service
