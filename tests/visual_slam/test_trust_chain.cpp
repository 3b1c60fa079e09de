// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/trust_chain.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace slamfuse::visual_slam {
namespace {

using Ids = std::vector<LandmarkId>;

TEST(TrustChain, TrustsEverythingWhileNothingWentWrong) { EXPECT_TRUE(TrustChain(3).see(Ids{})); }

TEST(TrustChain, HandsTrustOnToWhatIsSeenTogether) {
  TrustChain chain(3);
  chain.begin(Ids{1, 2, 3, 4});
  EXPECT_TRUE(chain.see(Ids{2, 3, 4, 10, 11, 12}));
  EXPECT_TRUE(chain.see(Ids{10, 11, 12, 20}));
}

TEST(TrustChain, BreaksAndIsMendedByTheOldMap) {
  TrustChain chain(3);
  chain.begin(Ids{1, 2, 3, 4});
  EXPECT_FALSE(chain.see(Ids{3, 4, 10, 11, 12}));
  EXPECT_FALSE(chain.see(Ids{10, 11, 12, 13}));
  EXPECT_TRUE(chain.see(Ids{1, 2, 3, 13}));
}

TEST(TrustChain, ASecondFaultDoesNotMakeTrustedWhatIsNot) {
  TrustChain chain(3);
  chain.begin(Ids{1, 2, 3});
  chain.begin(Ids{1, 2, 3, 10, 11, 12});
  EXPECT_FALSE(chain.see(Ids{10, 11, 12}));
  chain.end();
  EXPECT_FALSE(chain.is_watching());
  EXPECT_TRUE(chain.see(Ids{10}));
}

}  // namespace
}  // namespace slamfuse::visual_slam
