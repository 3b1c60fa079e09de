// SPDX-License-Identifier: BSD-3-Clause
#include "service/chart.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "service/markup_checks.hpp"
#include "service/plot_axis.hpp"

namespace slamfuse::service {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(NiceTicks, AreRoundNumbersInsideTheRange) {
  EXPECT_THAT(nice_ticks(0.0, 1.0, 5), ElementsAre(0.0, testing::DoubleEq(0.2), testing::DoubleEq(0.4),
                                                   testing::DoubleNear(0.6, 1e-12), testing::DoubleEq(0.8), 1.0));
  EXPECT_THAT(nice_ticks(-7.0, 12.0, 4), ElementsAre(-5.0, 0.0, 5.0, 10.0));
  EXPECT_THAT(nice_ticks(0.0, 128.0, 6), ElementsAre(0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0));
}

TEST(NiceTicks, NeverGiveMinusZero) {
  for (const double tick : nice_ticks(-1.0, 1.0, 4)) EXPECT_FALSE(tick == 0.0 && std::signbit(tick));
}

TEST(NiceTicks, AreNoneForARangeThatIsNone) {
  EXPECT_THAT(nice_ticks(1.0, 1.0, 5), IsEmpty());
  EXPECT_THAT(nice_ticks(2.0, 1.0, 5), IsEmpty());
  EXPECT_THAT(nice_ticks(kNan, 1.0, 5), IsEmpty());
  EXPECT_THAT(nice_ticks(0.0, INFINITY, 5), IsEmpty());
  EXPECT_LE(nice_ticks(1e17, 1e17 + 16.0, 5).size(), 101u) << "steps below the spacing of doubles end";
}

TEST(TickLabels, HaveTheDecimalsTheStepNeeds) {
  EXPECT_THAT(tick_labels({0.0, 0.05, 0.1}), ElementsAre("0.00", "0.05", "0.10"));
  EXPECT_THAT(tick_labels({0.0, 20.0}), ElementsAre("0", "20"));
  EXPECT_THAT(tick_labels({}), IsEmpty());
}

ChartPoints ramp_with_peak(std::size_t count, std::size_t peak) {
  ChartPoints points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(static_cast<double>(i), i == peak ? 1000.0 : 1.0);
  return points;
}

TEST(Decimate, LeavesShortSeriesAlone) {
  const auto points = ramp_with_peak(10, 3);
  EXPECT_EQ(decimate(points, 10), points);
}

TEST(Decimate, KeepsPeaksAndTheOrder) {
  const auto kept = decimate(ramp_with_peak(100000, 54321), 2000);
  EXPECT_LE(kept.size(), 2000u);
  EXPECT_NE(std::find(kept.begin(), kept.end(), Eigen::Vector2d(54321.0, 1000.0)), kept.end());
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.x() < b.x(); }));
}

TEST(Decimate, KeepsGaps) {
  ChartPoints points = ramp_with_peak(10000, 1);
  for (std::size_t i = 4000; i < 6000; ++i) points[i].y() = kNan;
  const auto kept = decimate(points, 100);
  EXPECT_TRUE(std::any_of(kept.begin(), kept.end(), [](const auto& p) { return std::isnan(p.y()); }));
}

ChartFrame frame() { return {.title = "A <title>", .x_label = "time [s]", .y_label = "error [m]"}; }

TEST(LineChart, IsWellFormedAndEscapesItsTexts) {
  const std::string svg = line_chart(frame(), {{"laser & co", "laser", {{0, 1}, {1, 2}}}});
  EXPECT_EQ(nesting_fault(svg), "");
  EXPECT_THAT(svg, HasSubstr("A &lt;title&gt;"));
  EXPECT_THAT(svg, HasSubstr("laser &amp; co"));
  EXPECT_THAT(svg, HasSubstr("time [s]"));
}

TEST(LineChart, IsEmptyWithoutAFinitePoint) {
  EXPECT_EQ(line_chart(frame(), {}), "");
  EXPECT_EQ(line_chart(frame(), {{"laser", "laser", {}}}), "");
  EXPECT_EQ(line_chart(frame(), {{"laser", "laser", {{0, kNan}, {kNan, 1}, {1, INFINITY}}}}), "");
}

TEST(LineChart, LeavesSeriesWithoutPointsOutOfTheLegend) {
  const std::string svg = line_chart(frame(), {{"laser", "laser", {{0, 1}}}, {"visual", "visual", {}}});
  EXPECT_THAT(svg, Not(HasSubstr(">visual<")));
}

TEST(LineChart, BreaksTheLineAtAGap) {
  const std::string svg = line_chart(frame(), {{"laser", "laser", {{0, 1}, {1, 1}, {2, kNan}, {3, 1}, {4, 1}}}});
  const std::size_t line = svg.rfind(" d=\"");
  EXPECT_EQ(occurrences(svg.substr(line), "M"), 2u);
}

TEST(LineChart, NeverWritesNumbersThatAreNone) {
  for (const ChartPoints& points :
       {ChartPoints{{0, 0}}, ChartPoints{{5, 0}, {5, 0}}, ChartPoints{{0, 1}, {1, INFINITY}, {2, kNan}}}) {
    const std::string svg = line_chart(frame(), {{"laser", "laser", points}});
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
  }
}

TEST(LineChart, StaysSmallForLongSeries) {
  const std::string svg = line_chart(frame(), {{"laser", "laser", ramp_with_peak(1000000, 3)}});
  EXPECT_LT(svg.size(), 40000u);
}

TEST(BandChart, DrawsEveryStretchInItsRow) {
  ChartFrame bands = frame();
  bands.x_max = 10.0;
  const std::string svg =
      band_chart(bands, {{"laser", {{0, 5, "tracking"}, {5, 10, "lost"}}}, {"visual", {{0, 10, "tracking"}}}},
                 {{"OK", "tracking"}});
  EXPECT_EQ(nesting_fault(svg), "");
  EXPECT_EQ(occurrences(svg, "<rect"), 4u) << "three stretches and the legend";
}

TEST(BandChart, IsEmptyWithoutStretchesOrTime) {
  ChartFrame bands = frame();
  EXPECT_EQ(band_chart(bands, {{"laser", {{0, 5, "tracking"}}}}, {}), "") << "no time range";
  bands.x_max = 10.0;
  EXPECT_EQ(band_chart(bands, {{"laser", {}}}, {}), "");
}

}  // namespace
}  // namespace slamfuse::service
