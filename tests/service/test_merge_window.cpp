// SPDX-License-Identifier: BSD-3-Clause
#include "service/merge_window.hpp"

#include <gtest/gtest.h>

namespace slamfuse::service {
namespace {

using common::PoseSource;

MergedStep step(SequenceIndex index) {
  MergedStep made;
  made.index = index;
  return made;
}

// Three steps: the first waits for the visual half, the second for the laser, the third for nobody.
void open_three(MergeWindow& window) {
  window.open(step(0), {PoseSource::kVisual});
  window.open(step(1), {PoseSource::kLaser});
  window.open(step(2), {});
  window.close();
}

TEST(MergeWindow, AReplayTakesStepsByIndex) {
  MergeWindow window(8);
  open_three(window);
  window.complete(1, PoseSource::kLaser, {});
  window.complete(0, PoseSource::kVisual, {});
  for (const SequenceIndex index : {0, 1, 2}) EXPECT_EQ(window.take()->index, index);
  EXPECT_FALSE(window.take());
}

TEST(MergeWindow, LiveTakesWhatIsCompleteFirst) {
  MergeWindow window(8, MergeOrder::kAsComplete);
  open_three(window);
  EXPECT_EQ(window.take()->index, 2);
  window.complete(1, PoseSource::kLaser, {});
  EXPECT_EQ(window.take()->index, 1);
  window.complete(2, PoseSource::kLaser, {});  // was taken without waiting for it
  window.complete(0, PoseSource::kVisual, {});
  EXPECT_EQ(window.take()->index, 0);
  EXPECT_FALSE(window.take());
}

// What waits for a slow module takes room, what has been taken does not.
TEST(MergeWindow, LiveASlowModuleDoesNotHoldUpTheReader) {
  MergeWindow window(2, MergeOrder::kAsComplete);
  window.open(step(0), {PoseSource::kVisual});
  for (SequenceIndex index = 1; index < 100; ++index) {
    ASSERT_TRUE(window.open(step(index), {}));
    ASSERT_EQ(window.take()->index, index);
  }
  window.complete(0, PoseSource::kVisual, {});
  EXPECT_EQ(window.take()->index, 0);
}

}  // namespace
}  // namespace slamfuse::service
