// SPDX-License-Identifier: BSD-3-Clause
#include "service/command_line.hpp"

#include <string>
#include <variant>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

common::Result<CommandRequest> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "slamfuse");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data());
}

TEST(CommandLine, ReadsEveryFlagOfRun) {
  const auto request = parse({"run",
                              "rec",
                              "-o",
                              "out",
                              "--modules",
                              "laser,visual",
                              "--cameras",
                              "cam0,cam1",
                              "--from",
                              "1.5",
                              "--to",
                              "9",
                              "--threads",
                              "3",
                              "--seed",
                              "18446744073709551615",
                              "--arrival-delay",
                              "cam0=0.2",
                              "--arrival-delay",
                              "laser0=1",
                              "--stamp-offset",
                              "cam1=-0.05",
                              "--dds",
                              "--rate",
                              "2",
                              "--map",
                              "m",
                              "--mode",
                              "slam",
                              "--visual-odometry",
                              "on",
                              "--set",
                              "laser.particles=7",
                              "--set",
                              "service.command_delay=3"});
  ASSERT_TRUE(request.has_value()) << request.error().message;
  const auto& run = std::get<RunRequest>(*request);
  EXPECT_EQ(run.recording, "rec");
  EXPECT_EQ(run.out, "out");
  EXPECT_THAT(run.modules, ElementsAre("laser", "visual"));
  EXPECT_THAT(run.cameras, ElementsAre("cam0", "cam1"));
  EXPECT_EQ(run.from, 1.5);
  EXPECT_EQ(run.to, 9.0);
  EXPECT_EQ(run.threads, 3);
  EXPECT_EQ(run.seed, 18446744073709551615ULL);
  EXPECT_EQ(run.arrival_delay.at("cam0"), 0.2);
  EXPECT_EQ(run.arrival_delay.at("laser0"), 1.0);
  EXPECT_EQ(run.stamp_offset.at("cam1"), -0.05);
  EXPECT_TRUE(run.dds);
  EXPECT_EQ(run.rate, 2.0);
  EXPECT_EQ(run.map, "m");
  EXPECT_EQ(run.configuration.laser.particles, 7);
  EXPECT_EQ(run.configuration.service.command_delay, 3);
}

TEST(CommandLine, TakesTheRecordingAfterARepeatableFlag) {
  const auto request = parse({"run", "-o", "out", "--set", "laser.particles=7", "--modules", "laser", "rec"});
  ASSERT_TRUE(request.has_value()) << request.error().message;
  EXPECT_EQ(std::get<RunRequest>(*request).recording, "rec");
}

TEST(CommandLine, HasDefaultsThatRunEverythingWholly) {
  const auto request = parse({"run", "rec", "-o", "out"});
  const auto& run = std::get<RunRequest>(*request);
  EXPECT_TRUE(run.modules.empty());
  EXPECT_TRUE(run.cameras.empty());
  EXPECT_EQ(run.from, 0.0);
  EXPECT_FALSE(run.to.has_value());
  EXPECT_GE(run.threads, 1);
  EXPECT_EQ(run.seed, 1U);
  EXPECT_FALSE(run.map.has_value());
}

TEST(CommandLine, RefusesASensorGivenTwiceOrWithoutANumber) {
  EXPECT_FALSE(parse({"run", "r", "-o", "o", "--arrival-delay", "a=1", "--arrival-delay", "a=2"}).has_value());
  for (const char* text : {"a", "a=", "=1", "a=x", "a=nan", "a=inf", "a=-1"}) {
    EXPECT_FALSE(parse({"run", "r", "-o", "o", "--arrival-delay", text}).has_value()) << text;
  }
}

TEST(CommandLine, GivesUsageErrorsTheirKind) {
  for (const auto& arguments : std::vector<std::vector<const char*>>{
           {}, {"run"}, {"run", "r"}, {"nonsense"}, {"align", "a", "-o", "o"}, {"evaluate", "a"}, {"info"}}) {
    const auto request = parse(arguments);
    ASSERT_FALSE(request.has_value());
    EXPECT_EQ(request.error().kind, common::ErrorKind::kUsage);
  }
}

TEST(CommandLine, PassesTheMethodOfAnAlignmentOn) {
  const auto request = parse({"align", "a", "b", "-o", "out", "--method", "seed004"});
  ASSERT_TRUE(request.has_value()) << request.error().message;
  EXPECT_EQ(std::get<AlignRequest>(*request).options.method, fusion::AlignmentMethod::kSeed004);
  EXPECT_FALSE(parse({"align", "a", "b", "-o", "out", "--method", "magic"}).has_value());
}

TEST(CommandLine, ReadsWhatEvaluateIsToCompare) {
  const auto request =
      parse({"evaluate", "est", "ref", "--align", "sim2", "--align-as", "e", "r", "--relations", "rel"});
  ASSERT_TRUE(request.has_value()) << request.error().message;
  const auto& evaluate = std::get<EvaluateRequest>(*request);
  EXPECT_EQ(evaluate.reference, "ref");
  EXPECT_EQ(evaluate.align, common::EvaluationAlignment::kSim2);
  EXPECT_EQ(evaluate.align_as->second, "r");
  EXPECT_EQ(evaluate.relations, "rel");
}

TEST(CommandLine, PrintsHelpOfTheProgramAndOfACommand) {
  EXPECT_THAT(std::get<PrintRequest>(*parse({"--help"})).text, HasSubstr("evaluate"));
  EXPECT_THAT(std::get<PrintRequest>(*parse({"run", "--help"})).text, HasSubstr("--arrival-delay"));
}

TEST(CommandLine, PrintsTheOptionsInThreeFormats) {
  EXPECT_THAT(std::get<PrintRequest>(*parse({"options"})).text, HasSubstr("particles: "));
  EXPECT_THAT(std::get<PrintRequest>(*parse({"options", "--format", "markdown"})).text, HasSubstr("laser.particles"));
  EXPECT_THAT(std::get<PrintRequest>(*parse({"options", "--format", "text"})).text, HasSubstr("laser.particles="));
}

TEST(CommandLine, ReadsPlay) {
  const auto request =
      parse({"play", "rec", "--rate", "2", "--stamps", "now", "--from", "1", "--to", "3", "--wait", "0"});
  ASSERT_TRUE(request);
  const auto& play = std::get<PlayRequest>(*request);
  EXPECT_EQ(play.recording, "rec");
  EXPECT_EQ(play.rate, 2.0);
  EXPECT_EQ(play.stamps, PlayStamps::kNow);
  EXPECT_EQ(play.from, 1.0);
  EXPECT_EQ(play.to, 3.0);
  EXPECT_EQ(play.wait, 0.0);
  EXPECT_EQ(play.times, 1);
  EXPECT_EQ(play.network, idl::Network::kLoopback);
  const auto open = parse({"play", "rec", "--times", "0", "--set", "service.dds.network=all"});
  ASSERT_TRUE(open) << open.error().message;
  EXPECT_EQ(std::get<PlayRequest>(*open).times, 0);
  EXPECT_EQ(std::get<PlayRequest>(*open).network, idl::Network::kAll);
  EXPECT_FALSE(parse({"play", "rec", "--times", "-1"}));
  EXPECT_FALSE(parse({"play", "rec", "--rate", "0"}));
  EXPECT_FALSE(parse({"play", "rec", "--stamps", "yesterday"}));
}

TEST(CommandLine, ReadsServe) {
  const auto request = parse({"serve", "-o", "out", "--topic", "laser0=/front/scan", "--base-frame", "base_footprint",
                              "--readout", "cam0=0.02", "--modules", "laser", "--map", "m", "--seed", "4"});
  ASSERT_TRUE(request);
  const auto& serve = std::get<ServeRequest>(*request);
  EXPECT_EQ(serve.run.out, "out");
  EXPECT_EQ(serve.source.inbox.topics.at("laser0"), "/front/scan");
  EXPECT_EQ(serve.source.base_frame, "base_footprint");
  EXPECT_EQ(serve.source.readout.at("cam0"), 0.02);
  EXPECT_THAT(serve.run.modules, ElementsAre("laser"));
  EXPECT_EQ(serve.run.map, "m");
  EXPECT_EQ(serve.run.seed, 4u);
  EXPECT_GE(serve.run.threads, 2);
  EXPECT_FALSE(parse({"serve"}));
  EXPECT_FALSE(parse({"serve", "-o", "out", "--mode", "localization"}));
  EXPECT_FALSE(parse({"serve", "-o", "out", "--readout", "cam0=-1"}));
}

TEST(CommandLine, ReadsRecordAndCall) {
  const auto recording = parse({"record", "-o", "bag", "--topics", "/scan", "tf", "--duration", "3"});
  ASSERT_TRUE(recording) << recording.error().message;
  const auto& record = std::get<RecordRequest>(*recording);
  EXPECT_EQ(record.out, "bag");
  EXPECT_EQ(record.topics, (std::vector<std::string>{"/scan", "tf"}));
  EXPECT_EQ(record.duration, 3.0);
  EXPECT_FALSE(parse({"record"}));
  const auto calling = parse({"call", "set_mode", "slam"});
  ASSERT_TRUE(calling) << calling.error().message;
  EXPECT_EQ(std::get<CallRequest>(*calling).service, "set_mode");
  EXPECT_EQ(std::get<CallRequest>(*calling).argument, "slam");
}

}  // namespace
}  // namespace slamfuse::service
