// SPDX-License-Identifier: BSD-3-Clause
#include "service/flag_values.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using testing::HasSubstr;

TEST(FlagValues, ANumberIsFiniteAndFromTheSmallestOn) {
  const auto check = [](std::string text) { return finite_from(0.5)(text); };
  EXPECT_EQ(check("0.5"), "");
  EXPECT_EQ(check("1e3"), "");
  for (const char* bad : {"0.4", "-1", "nan", "inf", "", "x"})
    EXPECT_THAT(check(bad), HasSubstr("not a number")) << bad;
}

TEST(FlagValues, ASeedIsAWholeNumber) {
  const auto check = [](std::string text) { return whole_number()(text); };
  EXPECT_EQ(check("0"), "");
  EXPECT_EQ(check("18446744073709551615"), "");
  for (const char* bad : {"-1", "1.5", "", "0x1"}) EXPECT_THAT(check(bad), HasSubstr("not a whole number")) << bad;
}

TEST(FlagValues, SecondsBySensor) {
  const auto good = parse_seconds_by_sensor("--readout", {"cam0=0.016", "cam1=0"}, 0.0);
  ASSERT_TRUE(good);
  EXPECT_EQ(good->at("cam0"), 0.016);
  EXPECT_EQ(good->at("cam1"), 0.0);
  for (const char* bad : {"cam0", "=1", "cam0=", "cam0=nan", "cam0=-1"}) {
    const auto refused = parse_seconds_by_sensor("--readout", {bad}, 0.0);
    ASSERT_FALSE(refused) << bad;
    EXPECT_THAT(refused.error().message, HasSubstr(bad));
  }
  EXPECT_TRUE(parse_seconds_by_sensor("--stamp-offset", {"cam0=-1"}, -HUGE_VAL));
  EXPECT_FALSE(parse_seconds_by_sensor("--readout", {"cam0=1", "cam0=2"}, 0.0));
}

}  // namespace
}  // namespace slamfuse::service
