// SPDX-License-Identifier: BSD-3-Clause
#include "service/markup.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

const std::string kReplacement = "\xEF\xBF\xBD";

TEST(Escape, DisarmsEveryCharacterThatHtmlReads) {
  EXPECT_EQ(escape("<script>alert(\"a\" & 'b')</script>"),
            "&lt;script&gt;alert(&quot;a&quot; &amp; &#39;b&#39;)&lt;/script&gt;");
}

TEST(Escape, KeepsProperUtf8) { EXPECT_EQ(escape("Zürich – 地図 🤖"), "Zürich – 地図 🤖"); }

TEST(Escape, ReplacesBytesThatAreNotUtf8) {
  EXPECT_EQ(escape("a\xFFz"), "a" + kReplacement + "z");
  EXPECT_EQ(escape("cut \xE2\x82"), "cut " + kReplacement + kReplacement);
  EXPECT_EQ(escape("\xC0\xBC"), kReplacement + kReplacement) << "an overlong '<'";
  EXPECT_EQ(escape("\xED\xA0\x80"), kReplacement + kReplacement + kReplacement) << "a surrogate";
}

TEST(Escape, ReplacesControlCharactersButKeepsLinesAndTabs) {
  EXPECT_EQ(escape(std::string_view("a\0b\x1b\n\t", 6)), "a" + kReplacement + "b" + kReplacement + "\n\t");
}

TEST(Number, HasTheDecimalsAskedFor) {
  EXPECT_EQ(number(1.0 / 3.0, 3), "0.333");
  EXPECT_EQ(number(12.0, 0), "12");
}

TEST(Number, IsADashWhenThereIsNone) {
  EXPECT_EQ(number(std::nan(""), 2), "–");
  EXPECT_EQ(number(std::numeric_limits<double>::infinity(), 2), "–");
}

}  // namespace
}  // namespace slamfuse::service
