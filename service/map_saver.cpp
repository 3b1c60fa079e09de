// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_saver.hpp"

#include <algorithm>
#include <utility>

#include "service/map_bundle.hpp"
#include "service/metrics.hpp"

namespace slamfuse::service {

using common::PoseSource;

MapSaver::MapSaver(std::filesystem::path path, std::uint64_t seed, std::string recording,
                   CurrentAlignment current_alignment, std::size_t most_poses)
    : path_(std::move(path)),
      seed_(seed),
      recording_(std::move(recording)),
      current_alignment_(std::move(current_alignment)),
      fused_(most_poses),
      writer_([this](const std::stop_token& done) { write_all(done); }) {}

MapSaver::~MapSaver() = default;

void MapSaver::on_corrected_pose(const fusion::CorrectedPose& pose) {
  if (pose.estimate.map_epoch != fused_epoch_) fused_.clear();  // poses of different epochs never mix
  fused_epoch_ = pose.estimate.map_epoch;
  fused_.push({pose.estimate.stamp, pose.estimate.pose});
}

void MapSaver::on_checkpoint(PoseSource source, const std::shared_ptr<const ModuleCheckpoint>& checkpoint) {
  modules_[source] = checkpoint;
  Snapshot snapshot{{}, modules_, current_alignment_(), fused_.items()};
  const std::lock_guard lock(mutex_);
  ++arrived_[source];
  snapshot.count = arrived_;
  next_ = std::move(snapshot);  // in place of one that still waits: only the newest matters
  wanted_.notify_one();
}

std::size_t MapSaver::saved() const {
  const std::lock_guard lock(mutex_);
  return saved_;
}

std::optional<common::Error> MapSaver::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void MapSaver::write_all(const std::stop_token& done) {
  while (true) {
    std::optional<Snapshot> snapshot;
    {
      std::unique_lock lock(mutex_);
      if (!wanted_.wait(lock, done, [this] { return next_.has_value(); })) return;
      snapshot = std::exchange(next_, std::nullopt);
    }
    const auto written = write(*snapshot);
    const std::lock_guard lock(mutex_);
    if (written) ++saved_;
    failure_ = written ? std::nullopt : std::optional(written.error());
    attempted_ = snapshot->count;
    written_.notify_all();
  }
}

common::Result<void> MapSaver::save_new(const std::set<PoseSource>& halves, const std::function<void()>& ask,
                                        std::chrono::nanoseconds patience) {
  std::unique_lock lock(mutex_);
  const Count before = arrived_;
  const auto count_of = [](const Count& count, PoseSource half) {
    const auto found = count.find(half);
    return found == count.end() ? 0 : found->second;
  };
  lock.unlock();
  ask();
  lock.lock();
  const bool done = written_.wait_for(lock, patience, [&] {
    return std::ranges::all_of(halves,
                               [&](PoseSource half) { return count_of(attempted_, half) > count_of(before, half); });
  });
  if (!done) {
    for (const PoseSource half : halves) {
      if (count_of(attempted_, half) > count_of(before, half)) continue;
      return common::failed("the " + common::to_string(half) +
                            " half made no pose meanwhile, so what was saved is older than this request");
    }
  }
  if (failure_) return tl::unexpected(*failure_);
  return {};
}

common::Result<void> MapSaver::write(const Snapshot& snapshot) const {
  MapBundle bundle;
  bundle.program_version = program_version();
  bundle.seed = seed_;
  bundle.recording = recording_;
  bundle.incomplete = true;
  bundle.alignment = snapshot.alignment;
  bundle.trajectories["fused"] = snapshot.fused;
  if (const auto laser = snapshot.modules.find(PoseSource::kLaser); laser != snapshot.modules.end()) {
    if (laser->second->grid) bundle.grid = &*laser->second->grid;
    bundle.laser_state = laser->second->laser_state;
    bundle.trajectories["laser"] = laser->second->path;
  }
  if (const auto visual = snapshot.modules.find(PoseSource::kVisual); visual != snapshot.modules.end()) {
    bundle.landmarks = visual->second->landmarks;
    bundle.keyframes = visual->second->keyframes;
    bundle.cameras = visual->second->cameras;
    bundle.trajectories["visual"] = visual->second->path;
  }
  return write_map_bundle(bundle, path_);
}

}  // namespace slamfuse::service
