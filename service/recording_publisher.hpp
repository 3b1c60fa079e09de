// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "common/error.hpp"
#include "common/recording.hpp"
#include "common/sensor_message.hpp"
#include "idl/participant.hpp"
#include "service/unsent_messages.hpp"

namespace slamfuse::service {

/// Publishes the messages of a recording as the robot's drivers would: sensors on topic_of() (sensor_topic.hpp),
/// `camN/camera_info` beside every picture, `tf` (odom -> base_link) beside the odometry, and the mountings once as
/// `tf_static`. Sensors' frames have the sensors' names.
class RecordingPublisher {
 public:
  /// Error (kFailed): DDS makes no writer.
  static common::Result<std::unique_ptr<RecordingPublisher>> create(const idl::Participant& participant,
                                                                    const common::RecordingInfo& info);
  ~RecordingPublisher();

  /// Waits at most so long [s] until every sensor's topic has a reader; says whether all have.
  bool wait_for_readers(double seconds);
  /// Tells mountings and calibrations, stamped `stamp`: what a listener needs before the first message.
  void introduce(common::Nanoseconds stamp);
  /// Publishes a message with this stamp instead of its own.
  void publish(const common::SensorMessage& message, common::Nanoseconds stamp);
  /// Waits at most so long [s] until reliable readers have everything.
  void finish(double seconds);

  const UnsentMessages& unsent() const;

 private:
  struct State;
  explicit RecordingPublisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace slamfuse::service
