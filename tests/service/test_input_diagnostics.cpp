// SPDX-License-Identifier: BSD-3-Clause
#include "service/input_diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

const InputDiagnostics::Time kStart = InputDiagnostics::Time() + 1h;

InputState scans(std::size_t received, InputDiagnostics::Time last) {
  InputState state;
  state.sensor = "laser0";
  state.topic = "scan";
  state.type = "sensor_msgs/msg/LaserScan";
  state.in_use = true;
  state.writers = 1;
  state.received = received;
  state.last_arrival = last;
  return state;
}

// The verdict after two seconds of scans at 10 Hz and then this.
Diagnosis then(const InputState& state, InputDiagnostics::Time now) {
  InputDiagnostics diagnostics;
  diagnostics.look({scans(0, kStart)}, kStart);
  diagnostics.look({scans(10, kStart + 1s)}, kStart + 1s);
  diagnostics.look({scans(20, kStart + 2s)}, kStart + 2s);
  const auto diagnoses = diagnostics.look({state}, now);
  return diagnoses.empty() ? Diagnosis{} : diagnoses.front();
}

TEST(InputDiagnostics, ASteadyTopicIsWell) {
  const auto diagnosis = then(scans(30, kStart + 3s), kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kOk);
  EXPECT_THAT(diagnosis.values, testing::Contains(testing::Pair("rate [Hz]", "10.00")));
}

TEST(InputDiagnostics, NamesATopicThatIsMatchedButSilent) {
  const auto diagnosis = then(scans(20, kStart + 2s), kStart + 4s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_THAT(diagnosis.message, HasSubstr("matched, but silent for 2.0 s"));
}

TEST(InputDiagnostics, NamesAPublisherThatHasGone) {
  InputState state = scans(20, kStart + 2s);
  state.writers = 0;
  EXPECT_THAT(then(state, kStart + 3s).message, HasSubstr("has gone"));
}

TEST(InputDiagnostics, NamesBothTypesWhereTheyDiffer) {
  InputState state;
  state.sensor = "laser0";
  state.topic = "scan";
  state.type = "sensor_msgs/msg/LaserScan";
  state.other_type = "sensor_msgs/msg/PointCloud2";
  const auto diagnosis = then(state, kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_THAT(diagnosis.message, HasSubstr("type mismatch: sensor_msgs/msg/PointCloud2 is published"));
  EXPECT_THAT(diagnosis.message, HasSubstr("expected is sensor_msgs/msg/LaserScan"));
}

TEST(InputDiagnostics, NamesThePolicyThatDoesNotMatch) {
  InputState state;
  state.sensor = "laser0";
  state.topic = "scan";
  state.incompatible_qos = "durability";
  const auto diagnosis = then(state, kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_THAT(diagnosis.message, HasSubstr("durability"));
}

TEST(InputDiagnostics, TellsWhatWasRejectedAndDroppedSinceTheLastLook) {
  InputState state = scans(30, kStart + 3s);
  state.rejected = 2;
  state.last_rejection = "stamp 5 repeats";
  EXPECT_THAT(then(state, kStart + 3s).message, HasSubstr("2 messages rejected: stamp 5 repeats"));
  state = scans(30, kStart + 3s);
  state.dropped = 4;
  const auto diagnosis = then(state, kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kWarning);
  EXPECT_THAT(diagnosis.message, HasSubstr("4 messages dropped"));
}

TEST(InputDiagnostics, NamesARateThatIsNotTheUsualOne) {
  InputDiagnostics diagnostics;
  std::size_t received = 0;
  auto now = kStart;
  for (int second = 0; second < 8; ++second, now += 1s, received += 10) diagnostics.look({scans(received, now)}, now);
  const auto faster = diagnostics.look({scans(received + 90, now)}, now);
  EXPECT_EQ(faster.front().level, DiagnosisLevel::kWarning);
  EXPECT_EQ(faster.front().message, "100.0 messages a second, usual are 10.0");
}

TEST(InputDiagnostics, APublisherThatComesBackMayHaveAnotherRate) {
  InputDiagnostics diagnostics;
  std::size_t received = 0;
  auto now = kStart;
  for (int second = 0; second < 8; ++second, now += 1s, received += 10) diagnostics.look({scans(received, now)}, now);
  auto gone = scans(received, now);
  gone.writers = 0;
  diagnostics.look({gone}, now);
  now += 1s;
  for (int second = 0; second < 8; ++second, now += 1s, received += 100) {
    EXPECT_EQ(diagnostics.look({scans(received, now)}, now).front().message, "ok");
  }
}

TEST(InputDiagnostics, NamesWhatIsWrongOfASensorInUse) {
  InputState state = scans(30, kStart + 3s);
  state.problem = "the transform came too late";
  const auto diagnosis = then(state, kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kWarning);
  EXPECT_EQ(diagnosis.message, "the transform came too late");
}

TEST(InputDiagnostics, NamesWhatIsMissingOfASensorThatIsHeard) {
  InputState state;
  state.sensor = "cam0";
  state.topic = "cam0/image_raw";
  state.type = "sensor_msgs/msg/Image";
  state.writers = 1;
  state.received = 5;
  state.last_arrival = kStart + 3s;
  state.problem = "no camera_info was heard of it";
  const auto diagnosis = then(state, kStart + 3s);
  EXPECT_EQ(diagnosis.level, DiagnosisLevel::kError);
  EXPECT_EQ(diagnosis.message, "cannot be used: no camera_info was heard of it");
}

TEST(InputDiagnostics, ACalibrationIsDueOnceAndNeverLate) {
  InputState state;
  state.sensor = "cam0";
  state.topic = "cam0/camera_info";
  state.type = "sensor_msgs/msg/CameraInfo";
  state.required = true;
  EXPECT_EQ(then(state, kStart + 3s).message, "nobody publishes it");
  state.writers = 1;
  EXPECT_EQ(then(state, kStart + 3s).message, "matched, but silent from the beginning");
  state.in_use = true;
  state.received = 1;
  state.last_arrival = kStart;
  EXPECT_EQ(then(state, kStart + 1h).message, "ok");
}

TEST(InputDiagnostics, PassesOverWhatNobodyUses) {
  InputState state;
  state.sensor = "cam3";
  state.topic = "cam3/image_raw";
  EXPECT_TRUE(InputDiagnostics().look({state}, kStart).empty());
}

TEST(InputDiagnostics, MissesWhatTheUserNamed) {
  InputState state;
  state.sensor = "cam0";
  state.topic = "front/image_raw";
  state.required = true;
  const auto diagnoses = InputDiagnostics().look({state}, kStart);
  ASSERT_EQ(diagnoses.size(), 1u);
  EXPECT_EQ(diagnoses.front().message, "nobody publishes it");
}

TEST(InputDiagnostics, BecomesARosMessage) {
  const auto message =
      to_ros_diagnostics(5, "slamfuse", {{"scan", DiagnosisLevel::kError, "silent", {{"age [s]", "2.0"}}}});
  ASSERT_EQ(message->status._length, 1u);
  EXPECT_EQ(message->status._buffer[0].level, 2);
  EXPECT_STREQ(message->status._buffer[0].name, "slamfuse: input scan");
  EXPECT_STREQ(message->status._buffer[0].values._buffer[0].value, "2.0");
}

}  // namespace
}  // namespace slamfuse::service
