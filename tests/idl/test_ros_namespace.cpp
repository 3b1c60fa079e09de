// SPDX-License-Identifier: BSD-3-Clause
#include "idl/ros_namespace.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace slamfuse::idl {
namespace {

TEST(RosNamespace, TheRootChangesNoName) {
  for (const char* root : {"", "/"}) {
    const auto names = RosNamespace::create(root).value();
    EXPECT_EQ(names.name(), "/");
    EXPECT_EQ(names.resolve("slamfuse/pose"), "slamfuse/pose");
    EXPECT_EQ(names.resolve("/tf"), "tf");
  }
}

TEST(RosNamespace, HoldsRelativeNamesAndNoAbsoluteOnes) {
  for (const char* text : {"robot_1/front", "/robot_1/front"}) {
    const auto names = RosNamespace::create(text).value();
    EXPECT_EQ(names.name(), "/robot_1/front");
    EXPECT_EQ(names.resolve("slamfuse/pose"), "robot_1/front/slamfuse/pose");
    EXPECT_EQ(names.resolve("/tf"), "tf");
  }
}

TEST(RosNamespace, RefusesWhatRosRefuses) {
  const std::vector<std::string> refused = {"1robot", "robot/", "//robot", "robot//front",   "robot/1",
                                            "ro bot", "~",      "{node}",  "rob\xc3\xb6ter", std::string(129, 'r')};
  for (const std::string& text : refused) {
    const auto names = RosNamespace::create(text);
    ASSERT_FALSE(names) << text;
    EXPECT_THAT(names.error().message, testing::HasSubstr("'" + text + "' is no ROS namespace"));
  }
}

}  // namespace
}  // namespace slamfuse::idl
