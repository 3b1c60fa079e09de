// SPDX-License-Identifier: BSD-3-Clause
#include "service/output_diagnostics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

TEST(OutputDiagnostics, TellsHowManyListen) {
  const auto diagnoses = diagnose_outputs({{"map", "nav_msgs/msg/OccupancyGrid", 2, {}}, {"tf", "", 0, {}}});
  ASSERT_EQ(diagnoses.size(), 2u);
  EXPECT_EQ(diagnoses[0].level, DiagnosisLevel::kOk);
  EXPECT_EQ(diagnoses[0].message, "2 readers");
  EXPECT_THAT(diagnoses[0].values, testing::Contains(testing::Pair("readers", "2")));
  EXPECT_EQ(diagnoses[1].level, DiagnosisLevel::kOk);
  EXPECT_EQ(diagnoses[1].message, "nobody listens");
}

TEST(OutputDiagnostics, NamesReadersThatGetNothing) {
  const auto diagnoses =
      diagnose_outputs({{"path", "", 1, {{"rviz2", "transient local requested, volatile offered"}}}});
  ASSERT_EQ(diagnoses.size(), 1u);
  EXPECT_EQ(diagnoses[0].level, DiagnosisLevel::kWarning);
  EXPECT_EQ(diagnoses[0].message, "1 reader; rviz2 gets nothing: transient local requested, volatile offered");
}

TEST(OutputDiagnostics, AreTellableFromInputs) {
  const auto message = to_ros_diagnostics(5, "slamfuse", diagnose_outputs({{"tf", "", 0, {}}}));
  ASSERT_EQ(message->status._length, 1u);
  EXPECT_STREQ(message->status._buffer[0].name, "slamfuse: output tf");
}

}  // namespace
}  // namespace slamfuse::service
