// SPDX-License-Identifier: BSD-3-Clause
#include "service/rejection_log.hpp"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using testing::HasSubstr;

TEST(RejectionLog, TellsTheFirstOfAKindInFull) {
  RejectionLog log;
  const auto event = log.add({5, "cam0", "cam0/data/5.jpg: 320x240, must be 640x480"});
  ASSERT_TRUE(event.has_value());
  EXPECT_EQ(event->stamp, 5);
  EXPECT_EQ(event->kind, "rejected");
  EXPECT_EQ(event->detail, "cam0: cam0/data/5.jpg: 320x240, must be 640x480");
}

TEST(RejectionLog, CountsReasonsThatDifferOnlyInFiguresAsOneKind) {
  RejectionLog log;
  log.add({5, "cam0", "cam0/data/5.jpg: cut"});
  EXPECT_FALSE(log.add({6, "cam0", "cam0/data/6.jpg: cut"}).has_value());
  ASSERT_EQ(log.summary().size(), 1U);
  EXPECT_THAT(log.summary()[0].detail, HasSubstr("2 messages"));
  EXPECT_THAT(log.summary()[0].detail, HasSubstr("cam0/data/5.jpg: cut"));
}

TEST(RejectionLog, KeepsSensorsAndReasonsApart) {
  RejectionLog log;
  EXPECT_TRUE(log.add({5, "cam0", "cut"}).has_value());
  EXPECT_TRUE(log.add({5, "cam1", "cut"}).has_value());
  EXPECT_TRUE(log.add({5, "cam0", "garbled"}).has_value());
  EXPECT_TRUE(log.summary().empty());
}

TEST(RejectionLog, IsBoundedWhateverReasonsAreMadeUp) {
  RejectionLog log;
  std::size_t told = 0;
  for (std::size_t i = 0; i < 100 * RejectionLog::kMostKinds; ++i) {
    std::string reason = "encoding '";
    for (std::size_t rest = i; rest > 0; rest /= 26) reason += static_cast<char>('a' + rest % 26);
    told += log.add({5, "cam0", reason + "' is none"}).has_value() ? 1 : 0;
  }
  EXPECT_LE(told, RejectionLog::kMostKinds + 1);
  EXPECT_EQ(log.summary().size(), 1u);
}

}  // namespace
}  // namespace slamfuse::service
