// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/sensor_message.hpp"

namespace slamfuse::service {

/// The ROS topic on which a sensor of this name and kind is heard: `scan` for laser0, `scan1` for laser1, `odom`,
/// `cam0/image_raw`, `imu0/data`.
std::string topic_of(const std::string& sensor, common::SensorKind kind);

/// Publishes the messages of a recording as the robot's drivers would: sensors on topic_of(), `camN/camera_info` beside
/// every picture, `tf` (odom -> base_link) beside the odometry, and the mountings once as `tf_static`. Sensors' frames
/// have the sensors' names. The domain is that of the environment.
class RecordingPublisher {
 public:
  /// Errors: a bad ROS_DOMAIN_ID (kInvalidInput), DDS cannot start (kFailed).
  static common::Result<std::unique_ptr<RecordingPublisher>> create(const common::RecordingInfo& info);
  ~RecordingPublisher();

  /// Waits at most so long [s] until every sensor's topic has a reader; says whether all have.
  bool wait_for_readers(double seconds);
  /// Tells mountings and calibrations, stamped `stamp`: what a listener needs before the first message.
  void introduce(common::Nanoseconds stamp);
  /// Publishes a message with this stamp instead of its own.
  void publish(const common::SensorMessage& message, common::Nanoseconds stamp);
  /// Waits at most so long [s] until reliable readers have everything.
  void finish(double seconds);

  /// Messages that could not be sent, and why the first could not.
  std::size_t failures() const;
  const std::optional<common::Error>& first_failure() const;

 private:
  struct State;
  explicit RecordingPublisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::service
