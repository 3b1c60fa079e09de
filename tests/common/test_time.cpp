// SPDX-License-Identifier: BSD-3-Clause
#include "common/time.hpp"

#include <gtest/gtest.h>

namespace slamfuse::common {
namespace {

TEST(ParseDecimalSeconds, KeepsEveryDigitOfAUnixStamp) {
  EXPECT_EQ(parse_decimal_seconds("1538499903.588082075"), 1538499903588082075);
  EXPECT_EQ(parse_decimal_seconds("976052857.337284"), 976052857337284000);
}

TEST(ParseDecimalSeconds, ReadsSignsExponentsAndBareNumbers) {
  EXPECT_EQ(parse_decimal_seconds("0"), 0);
  EXPECT_EQ(parse_decimal_seconds("-0.5"), -500000000);
  EXPECT_EQ(parse_decimal_seconds("+.25"), 250000000);
  EXPECT_EQ(parse_decimal_seconds("1.5e3"), 1500000000000);
  EXPECT_EQ(parse_decimal_seconds("1e-9"), 1);
  EXPECT_EQ(parse_decimal_seconds("1e-300"), 0);
  EXPECT_EQ(parse_decimal_seconds("0.0000000019"), 1);
}

TEST(ParseDecimalSeconds, RefusesWhatIsNoFiniteNumberThatFits) {
  for (const char* text :
       {"", "-", ".", "nan", "inf", "1.2.3", "1,5", "12 ", " 12", "1e", "1e99999", "99999999999", "0x10"}) {
    EXPECT_EQ(parse_decimal_seconds(text), std::nullopt) << text;
  }
}

TEST(ParseDecimalSeconds, RefusesTimesSoFarOffThatDifferencesOfTwoCouldOverflow) {
  EXPECT_EQ(parse_decimal_seconds("4000000000"), kLatestStamp);
  EXPECT_EQ(parse_decimal_seconds("-4000000000"), -kLatestStamp);
  for (const char* text : {"4000000000.000000001", "-4000000000.1", "9223372036", "-9223372036"}) {
    EXPECT_EQ(parse_decimal_seconds(text), std::nullopt) << text;
  }
}

TEST(FormatSeconds, WritesNineDecimalsAndReadsBackTheSame) {
  EXPECT_EQ(format_seconds(1700000000005000000), "1700000000.005000000");
  for (const Nanoseconds t :
       {Nanoseconds{0}, Nanoseconds{-1}, Nanoseconds{-1500000000}, Nanoseconds{976052857337284000}}) {
    EXPECT_EQ(parse_decimal_seconds(format_seconds(t)), t);
  }
}

}  // namespace
}  // namespace slamfuse::common
