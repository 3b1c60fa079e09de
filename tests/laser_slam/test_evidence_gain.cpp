// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/evidence_gain.hpp"

#include <gtest/gtest.h>

namespace slamfuse::laser_slam {
namespace {

TEST(EvidenceGain, GivesSparseSensorsTheEvidenceOfDenseOnes) {
  const EvidenceGain gain{0.05, 9.0};
  EXPECT_DOUBLE_EQ(gain.of(180) * 180, 9.0);
  EXPECT_DOUBLE_EQ(gain.of(90) * 90, 9.0);
  EXPECT_DOUBLE_EQ(gain.of(45) * 45, 9.0);
  EXPECT_DOUBLE_EQ(gain.of(720), 0.05) << "more beams are more evidence";
  EXPECT_DOUBLE_EQ(gain.of(4), 0.2) << "a beam never counts more than four times as much";
  EXPECT_DOUBLE_EQ(gain.of(0), 0.05) << "the number of beams varies";
}

}  // namespace
}  // namespace slamfuse::laser_slam
