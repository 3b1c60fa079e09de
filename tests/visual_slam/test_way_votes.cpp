// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/way_votes.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "visual_slam/synthetic_world.hpp"

namespace slamfuse::visual_slam {
namespace {

using testing::Noise;
using Votes = std::vector<WayVote>;

constexpr WayRange kRange{-0.05, 0.25};
constexpr double kSigma = 0.004;

void add_floor(Votes& votes, int count, double way, Noise& noise) {
  for (int i = 0; i < count; ++i) votes.push_back({way + kSigma * noise.gaussian(), kSigma});
}

/// Things up to half as high as the camera.
void add_above(Votes& votes, int count, double way, Noise& noise) {
  for (int i = 0; i < count; ++i) {
    const double height = 0.05 + 0.45 * noise.uniform();  // as a share of the camera's
    votes.push_back({way / (1.0 - height) + kSigma * noise.gaussian(), kSigma});
  }
}

void add_anything(Votes& votes, int count, Noise& noise) {
  for (int i = 0; i < count; ++i) {
    votes.push_back({kRange.least + (kRange.most - kRange.least) * noise.uniform(), kSigma});
  }
}

TEST(WayVotes, VotesOfTheFloorGiveItsWay) {
  for (const double way : {-0.03, 0.0, 0.02, 0.1, 0.2}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      Noise noise(seed);
      Votes votes;
      add_floor(votes, 40, way, noise);
      const auto found = likeliest_way(votes, kRange);
      ASSERT_TRUE(found) << way << ' ' << seed;
      EXPECT_NEAR(*found, way, 0.002) << seed;
    }
  }
}

// Their mean would be too long by far.
TEST(WayVotes, ThingsAboveTheFloorAndWrongVotesDoNotLengthenTheWay) {
  for (const double way : {0.04, 0.1, 0.14}) {
    for (const unsigned seed : {1U, 2U, 3U}) {
      Noise noise(seed);
      Votes votes;
      add_floor(votes, 48, way, noise);
      add_above(votes, 48, way, noise);
      add_anything(votes, 24, noise);
      const auto found = likeliest_way(votes, kRange);
      ASSERT_TRUE(found) << way << ' ' << seed;
      EXPECT_NEAR(*found, way, 0.003) << seed;
    }
  }
}

TEST(WayVotes, BackingUpThingsAboveTheFloorSeemToMoveFartherBack) {
  Noise noise(1);
  Votes votes;
  add_floor(votes, 48, -0.06, noise);
  add_above(votes, 48, -0.06, noise);
  const auto found = likeliest_way(votes, {-0.15, 0.15});
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, -0.06, 0.003);
}

TEST(WayVotes, AnExactVoteCountsMoreThanAVagueOne) {
  Votes votes;
  for (int i = 0; i < 40; ++i) votes.push_back({0.100, 0.002});
  for (int i = 0; i < 40; ++i) votes.push_back({0.106, 0.008});
  const auto found = likeliest_way(votes, kRange);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, 0.100 + 0.006 / 17.0, 0.0005);
}

TEST(WayVotes, NoVotesGiveNothing) { EXPECT_FALSE(likeliest_way({}, kRange)); }

TEST(WayVotes, AFewVotesAreNotEnough) {
  const Votes votes(2, {0.1, kSigma});
  EXPECT_FALSE(likeliest_way(votes, kRange));
}

TEST(WayVotes, VotesSpreadEvenlyGiveNothing) {
  Votes votes;
  for (int i = 0; i < 75; ++i) votes.push_back({kRange.least + (i + 0.5) * 0.004, kSigma});
  EXPECT_FALSE(likeliest_way(votes, kRange));
}

// One ahead and one back: neither can be of things above the floor if the other is the floor's.
TEST(WayVotes, TwoWaysEquallyStrongGiveNothing) {
  for (const int count : {10, 40, 100}) {
    Noise noise(7);
    Votes votes;
    add_floor(votes, count, 0.05, noise);
    for (int i = 0; i < count; ++i) votes.push_back({-votes[static_cast<std::size_t>(i)].way, kSigma});
    EXPECT_FALSE(likeliest_way(votes, {-0.15, 0.15})) << count;
  }
}

// A bed beside the floor: of two ways ahead the longer is that of something above the floor.
TEST(WayVotes, OfTwoWaysAheadTheShorterIsTheFloors) {
  Noise noise(1);
  Votes votes;
  add_floor(votes, 60, 0.08, noise);
  add_floor(votes, 60, 0.14, noise);
  const auto found = likeliest_way(votes, kRange);
  ASSERT_TRUE(found);
  EXPECT_NEAR(*found, 0.08, 0.003);
}

// The true one may lie beyond.
TEST(WayVotes, AWayAtTheEndOfTheRangeGivesNothing) {
  for (const double way : {kRange.least, kRange.most}) {
    const Votes votes(50, {way, kSigma});
    EXPECT_FALSE(likeliest_way(votes, kRange)) << way;
  }
}

TEST(WayVotes, TheirOrderDoesNotMatter) {
  Noise noise(5);
  Votes votes;
  add_floor(votes, 30, 0.1, noise);
  add_above(votes, 20, 0.1, noise);
  add_anything(votes, 10, noise);
  const auto found = likeliest_way(votes, kRange);
  std::reverse(votes.begin(), votes.end());
  const auto reversed = likeliest_way(votes, kRange);
  ASSERT_TRUE(found);
  ASSERT_TRUE(reversed);
  EXPECT_NEAR(*found, *reversed, 1e-12);
}

}  // namespace
}  // namespace slamfuse::visual_slam
