// SPDX-License-Identifier: BSD-3-Clause
#include "service/report.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/markup_checks.hpp"
#include "service/report_charts.hpp"
#include "service/report_tables.hpp"
#include "service/synthetic_report.hpp"

namespace slamfuse::service {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kShort = 600;

TEST(Report, IsWellFormedAndHasAllSections) {
  const std::string html = make_report(synthetic_report(kShort));
  EXPECT_EQ(nesting_fault(html), "");
  for (const char* part :
       {"<!DOCTYPE html>", "Map</h2>", "Accuracy</h2>", "Error over time</h2>", "Position error", "Heading error",
        "Structure and motion</h2>", "What the cameras saw</h2>", "Alignment of the visual with the laser path</h2>",
        "State over time</h2>", "Health over time</h2>", "Effective particles", "Features", "Modules</h2>",
        "Computing time</h2>", "Events</h2>", "sim/made_up", "loop_closed", "odometry"}) {
    EXPECT_THAT(html, HasSubstr(part));
  }
}

TEST(Report, NeedsNothingFromOutside) {
  const std::string html = make_report(synthetic_report(kShort));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, Not(HasSubstr("<link")));
  EXPECT_THAT(html, Not(HasSubstr("src=")));
  EXPECT_THAT(html, Not(HasSubstr("url(")));
  EXPECT_THAT(html, Not(HasSubstr("@import")));
  EXPECT_EQ(occurrences(html, "href="),
            occurrences(html, "href=\"data:image/png;base64,") + occurrences(html, "href=\"data:image/jpeg;base64,"));
}

TEST(Report, IsTheSameForTheSameData) {
  EXPECT_EQ(make_report(synthetic_report(kShort)), make_report(synthetic_report(kShort)));
}

TEST(Report, EscapesEveryTextFromOutside) {
  const std::string attack = "<img src=x onerror='alert(1)'>\"&";
  ReportData data = synthetic_report(kShort);
  data.version = data.recording = attack;
  for (auto& event : data.events) event.module = event.kind = event.detail = attack;
  for (auto& row : data.accuracy) row.name = row.align = attack;
  for (auto& row : data.modules) row.name = attack;
  data.alignment->accepted = false;
  data.alignment->reason = data.alignment->method = attack;
  const std::string html = make_report(data);
  EXPECT_THAT(html, Not(HasSubstr("<img")));
  EXPECT_THAT(html, Not(HasSubstr("onerror='")));
  EXPECT_EQ(nesting_fault(html), "");
}

TEST(Report, SaysWhatIsMissingWhenThereIsNothing) {
  const std::string html = make_report(ReportData());
  EXPECT_EQ(nesting_fault(html), "");
  EXPECT_THAT(html, HasSubstr("No ground truth"));
  EXPECT_THAT(html, HasSubstr("No estimator gave a pose"));
  EXPECT_THAT(html, HasSubstr("neither a map nor a path"));
  EXPECT_THAT(html, Not(HasSubstr("<svg")));
}

TEST(Report, StaysBoundedForLongRuns) {
  const std::size_t size_of_hour = make_report(synthetic_report(36000)).size();
  const std::size_t size_of_hours = make_report(synthetic_report(144000)).size();
  EXPECT_LT(size_of_hour, 1'500'000u);
  EXPECT_LT(size_of_hours, 1'500'000u);
}

TEST(Report, ShowsTheErrorsAlsoWithoutTheOdometryThatDwarfsThem) {
  const auto charts = error_charts(synthetic_report(kShort));
  ASSERT_EQ(charts.size(), 4u);
  EXPECT_THAT(charts[0], Not(HasSubstr(">odometry<")));
  EXPECT_THAT(charts[2], HasSubstr(">odometry<"));
}

TEST(EventTable, ListsSoManyEventsInOrderAndCountsTheRest) {
  ReportData data;
  for (std::size_t i = 0; i < kMaxListedEvents + 30; ++i) {
    data.events.push_back({static_cast<common::Nanoseconds>(1000 - i), "laser", i < 30 ? "rejected" : "lost", "x"});
  }
  const std::string html = event_table(data);
  EXPECT_EQ(occurrences(html, "<tr>"), kMaxListedEvents + 1);
  EXPECT_THAT(html, HasSubstr("and 30 more: 30 laser rejected"));
}

TEST(AlignmentTable, GivesTheReasonOfARefusal) {
  ReportData data = synthetic_report(kShort);
  data.alignment->accepted = false;
  data.alignment->reason = "the path is straight";
  EXPECT_THAT(alignment_table(data), HasSubstr("<strong>Refused</strong>"));
  EXPECT_THAT(alignment_table(data), HasSubstr("the path is straight"));
}

ReportSource estimates_at(const std::vector<std::pair<double, common::TrackingState>>& states) {
  StateHistory history;
  for (const auto& [seconds, state] : states) history.push(common::from_seconds(seconds), state);
  ReportSource source;
  source.states = history.stretches();
  return source;
}

constexpr auto kTracking = common::TrackingState::kTracking;
constexpr auto kUncertain = common::TrackingState::kUncertain;

TEST(StateBands, JoinNeighboursAndCallSilenceLost) {
  const auto bands =
      state_bands(estimates_at({{0.1, kTracking}, {0.4, kTracking}, {0.7, kUncertain}, {3.0, kTracking}}), 0, 3.2);
  ASSERT_EQ(bands.size(), 4u);
  EXPECT_EQ(bands[0].style, "tracking");
  EXPECT_DOUBLE_EQ(bands[0].to, 0.7);
  EXPECT_EQ(bands[1].style, "uncertain");
  EXPECT_DOUBLE_EQ(bands[1].to, 1.2) << "a pose counts for half a second";
  EXPECT_EQ(bands[2].style, "lost");
  EXPECT_DOUBLE_EQ(bands[2].to, 3.0);
  EXPECT_EQ(bands[3].style, "tracking");
  EXPECT_DOUBLE_EQ(bands[3].to, 3.2);
}

TEST(StateBands, AreLostBeforeALateFirstPoseAndAfterTheLast) {
  const auto bands = state_bands(estimates_at({{2.0, kTracking}}), 0, 5.0);
  ASSERT_EQ(bands.size(), 3u);
  EXPECT_EQ(bands[0].style, "lost");
  EXPECT_DOUBLE_EQ(bands[0].to, 2.0);
  EXPECT_EQ(bands[2].style, "lost");
  EXPECT_DOUBLE_EQ(bands[2].to, 5.0);
}

TEST(StateBands, ShowEveryLossWhenThereAreTooManyToDraw) {
  std::vector<std::pair<double, common::TrackingState>> states;
  for (int i = 0; i < 20000; ++i) states.emplace_back(0.1 * i, i % 2 == 0 ? kTracking : kUncertain);
  states[10000].second = common::TrackingState::kLost;
  const auto bands = state_bands(estimates_at(states), 0, 2000.0);
  EXPECT_LE(bands.size(), 1000u);
  EXPECT_TRUE(std::any_of(bands.begin(), bands.end(), [](const Band& band) { return band.style == "lost"; }));
}

TEST(StateBands, StandStampsThatStepBack) {
  for (const Band& band : state_bands(estimates_at({{1.0, kTracking}, {0.5, kUncertain}, {1.2, kTracking}}), 0, 2.0)) {
    EXPECT_LT(band.from, band.to);
  }
}

TEST(Verdict, NamesLossesErrorsAndAgreement) {
  const std::string words = verdict_in_words(synthetic_report(kShort));
  EXPECT_THAT(words, HasSubstr("laser and fused always had a pose"));
  EXPECT_THAT(words, HasSubstr("visual had no pose for"));
  EXPECT_THAT(words, HasSubstr("0.027 m from the truth"));
  EXPECT_THAT(words, HasSubstr("0.590 m off"));
  EXPECT_THAT(words, HasSubstr("0.071 m (rms of 640 pairs)"));
}

TEST(Verdict, SaysThatARunWasInterruptedOrRefused) {
  ReportData data = synthetic_report(kShort);
  data.complete = false;
  data.alignment->accepted = false;
  data.alignment->reason = "the path is straight";
  EXPECT_THAT(verdict_in_words(data), HasSubstr("was interrupted"));
  EXPECT_THAT(verdict_in_words(data), HasSubstr("was refused: the path is straight."));
}

}  // namespace
}  // namespace slamfuse::service
