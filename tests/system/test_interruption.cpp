// SPDX-License-Identifier: BSD-3-Clause
// Ctrl-C: ends within 2 s with exit status 130; what was computed is written and marked incomplete.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "system/program.hpp"
#include "system/scratch.hpp"

namespace slamfuse::system {
namespace {

using testing::Contains;
using testing::HasSubstr;

class Interruption : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Threads, Interruption, testing::Values("1", "2"));

TEST_P(Interruption, WritesWhatIsThereMarkedIncomplete) {
  const Scratch scratch;
  Launch launch{
      {"run", flat().string(), "-o", (scratch / "out").string(), "--threads", GetParam(), "--rate", "1"}, {}, 2.5};
  const Outcome outcome = run_program(launch);
  EXPECT_EQ(outcome.exit_status, 130) << outcome.err;
  EXPECT_LT(outcome.seconds, 2.0);
  EXPECT_THAT(outcome.err, HasSubstr("interrupted"));
  const auto metrics = read_json(scratch / "out/metrics.json");
  EXPECT_EQ(metrics["incomplete"], true);
  EXPECT_LT(metrics["duration_s"], 10.0);
  EXPECT_GT(metrics["duration_s"], 0.0);
  EXPECT_THAT(read_text(scratch / "out/map/map.yaml"), HasSubstr("incomplete: true"));
  EXPECT_THAT(read_lines(scratch / "out/laser.tum").front(), HasSubstr("incomplete"));
  EXPECT_THAT(names_in(scratch / "out"), Contains("report.html"));
}

TEST_P(Interruption, EndsAtFullSpeedToo) {
  const Scratch scratch;
  const Outcome outcome =
      run_program(Launch{{"run", flat().string(), "-o", (scratch / "out").string(), "--threads", GetParam()}, {}, 1.5});
  EXPECT_EQ(outcome.exit_status, 130) << outcome.err;
  EXPECT_LT(outcome.seconds, 2.0);
}

TEST(InterruptedCommand, EndsACommandThatWaitsForItsInput) {
  const Scratch scratch;
  const std::string pipe = (scratch / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const Outcome outcome =
      run_program(Launch{{"run", flat().string(), "-o", (scratch / "out").string(), "--config", pipe}, {}, 1.0});
  EXPECT_EQ(outcome.exit_status, 130) << outcome.err;
  EXPECT_LT(outcome.seconds, 2.0);
}

}  // namespace
}  // namespace slamfuse::system
