// SPDX-License-Identifier: BSD-3-Clause
#include "service/dds_publisher.hpp"

#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/reader.hpp"
#include "service/ros_conversion.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;
using common::PoseSource;

constexpr auto kPatience = 5s;
constexpr common::Nanoseconds kStamp = 1700000000005000000;

class DdsPublisherTest : public testing::Test {
 protected:
  template <class T>
  idl::Reader<T> listen(const std::string& topic, idl::QosProfile profile = idl::QosProfile::kTransformInput) {
    return idl::Reader<T>::create(participant_, topic, profile).value();
  }

  std::unique_ptr<DdsPublisher> publisher(DdsPublisher::CurrentAlignment alignment = [] {
    return std::optional<fusion::Alignment>();
  }) {
    const auto outputs = DdsOutputs::create(participant_, names_, options_.publish_tf);
    EXPECT_TRUE(outputs);
    return std::make_unique<DdsPublisher>(*outputs, options_, std::move(alignment));
  }

  static common::PoseEstimate estimate(PoseSource source, double x, common::Nanoseconds stamp = kStamp) {
    common::PoseEstimate estimate;
    estimate.stamp = stamp;
    estimate.source = source;
    estimate.pose = {x, 2.0, 0.5};
    estimate.covariance = 0.01 * Eigen::Matrix3d::Identity();
    return estimate;
  }

  idl::PrivateDomain domain_;
  idl::Participant participant_ = idl::Participant::create(domain_.settings()).value();
  DdsOptions options_;
  idl::RosNamespace names_;
};

TEST_F(DdsPublisherTest, SendsEachCorrectedPoseWithItsTransform) {
  auto poses = listen<idl::PoseWithCovarianceStamped>("slamfuse/pose");
  auto transforms = listen<idl::TFMessage>("tf");
  auto publishing = publisher();
  publishing->on_corrected_pose({estimate(PoseSource::kFused, 1.0), {0.1, 0.2, 0.3}});

  const auto pose = poses.take(kPatience);
  ASSERT_TRUE(pose && *pose);
  EXPECT_EQ((**pose)->pose.pose.position.x, 1.0);
  EXPECT_EQ((**pose)->pose.covariance[35], 0.01);
  EXPECT_EQ(idl::text_of((**pose)->header.frame_id), "map");
  EXPECT_EQ(from_ros_time((**pose)->header.stamp), kStamp);

  const auto transform = transforms.take(kPatience);
  ASSERT_TRUE(transform && *transform);
  EXPECT_EQ((**transform)->transforms._buffer[0].transform.translation.y, 0.2);
  EXPECT_EQ(idl::text_of((**transform)->transforms._buffer[0].child_frame_id), "odom");
  EXPECT_EQ(publishing->unsent().count, 0u);
}

TEST_F(DdsPublisherTest, StampsOfPosesRise) {
  auto poses = listen<idl::PoseWithCovarianceStamped>("slamfuse/pose");
  auto transforms = listen<idl::TFMessage>("tf");
  auto publishing = publisher();
  for (const common::Nanoseconds stamp : {kStamp, kStamp, kStamp - 1, kStamp + 1}) {
    publishing->on_corrected_pose({estimate(PoseSource::kFused, 1.0, stamp), {}});
  }
  for (const common::Nanoseconds stamp : {kStamp, kStamp + 1}) {
    EXPECT_EQ(from_ros_time((*poses.take(kPatience).value())->header.stamp), stamp);
    EXPECT_TRUE(transforms.take(kPatience).value());
  }
  EXPECT_FALSE(poses.take().value());
  EXPECT_FALSE(transforms.take().value());
}

TEST_F(DdsPublisherTest, PublishesInItsNamespaceWithoutTransformsWhenAnotherProcessHasThem) {
  options_.publish_tf = false;
  names_ = idl::RosNamespace::create("/robot/laser").value();
  auto poses = listen<idl::PoseWithCovarianceStamped>("robot/laser/slamfuse/pose");
  auto outside = listen<idl::PoseWithCovarianceStamped>("slamfuse/pose");
  auto transforms = listen<idl::TFMessage>("tf");
  auto publishing = publisher();
  publishing->on_corrected_pose({estimate(PoseSource::kFused, 1.0), {0.1, 0.2, 0.3}});
  EXPECT_TRUE(poses.take(kPatience).value());
  EXPECT_FALSE(outside.take(100ms).value());
  EXPECT_EQ(transforms.matched_writers(), 0);
}

TEST_F(DdsPublisherTest, TransformsAreTheSameForAllNamespaces) {
  names_ = idl::RosNamespace::create("/robot").value();
  auto transforms = listen<idl::TFMessage>("tf");
  publisher()->on_corrected_pose({estimate(PoseSource::kFused, 1.0), {0.1, 0.2, 0.3}});
  EXPECT_TRUE(transforms.take(kPatience).value());
}

TEST_F(DdsPublisherTest, TellsAnotherSystemItsPose) {
  auto poses = listen<idl::PoseWithCovarianceStamped>("amcl/initialpose");
  const auto outputs = DdsOutputs::create(participant_, {}, true).value();
  ASSERT_TRUE(outputs->add_initial_pose(participant_, PoseSource::kLaser, "/amcl/initialpose"));
  ASSERT_TRUE(outputs->add_initial_pose(participant_, PoseSource::kVisual, ""));
  DdsPublisher publishing(outputs, options_, [] { return std::optional<fusion::Alignment>(); });
  publishing.on_command(PoseSource::kVisual, common::SetPose{{5.0, 0.0, 0.0}});
  publishing.on_command(PoseSource::kLaser, common::SetPose{{1.0, 2.0, 0.5}, 0.25 * Eigen::Matrix3d::Identity()});
  const auto told = poses.take(kPatience).value();
  ASSERT_TRUE(told);
  EXPECT_EQ((*told)->pose.pose.position.y, 2.0);
  EXPECT_EQ((*told)->pose.covariance[0], 0.25);
  EXPECT_EQ(idl::text_of((*told)->header.frame_id), "map");
}

TEST_F(DdsPublisherTest, TellsARestartedSystemWhereItIs) {
  auto poses = listen<idl::PoseWithCovarianceStamped>("amcl/initialpose");
  const auto outputs = DdsOutputs::create(participant_, {}, true).value();
  ASSERT_TRUE(outputs->add_initial_pose(participant_, PoseSource::kLaser, "/amcl/initialpose"));
  DdsPublisher publishing(outputs, options_, [] { return std::optional<fusion::Alignment>(); });
  const common::Event restarted{kStamp, "laser", "restarted", ""};
  publishing.on_event(restarted);  // nobody knows yet
  publishing.on_corrected_pose({estimate(PoseSource::kFused, 1.5), {}});
  publishing.on_event({kStamp, "laser", "map_reset", ""});
  publishing.on_event({kStamp, "visual", "restarted", ""});  // is told nothing
  publishing.on_event(restarted);
  const auto told = poses.take(kPatience).value();
  ASSERT_TRUE(told);
  EXPECT_EQ((*told)->pose.pose.position.x, 1.5);
  EXPECT_FALSE(poses.take(50ms).value());
}

TEST(DdsOptions, TheNamespaceIsChecked) {
  DdsOptions options;
  EXPECT_EQ(namespace_of(options)->name(), "/");
  options.name_space = "1robot";
  EXPECT_THAT(namespace_of(options).error().message, testing::StartsWith("service.dds.namespace: '1robot'"));
}

TEST_F(DdsPublisherTest, SendsTheLastMapEvenRightAfterAnother) {
  auto publishing = publisher();
  auto map = std::make_shared<common::OccupancyGrid>();
  map->width = map->height = 1;
  map->cells = {0};
  publishing->on_map(kStamp, map);
  common::OccupancyGrid last = *map;
  last.cells = {100};
  publishing->finish({.map = &last});
  auto maps = listen<idl::OccupancyGrid>("map", idl::QosProfile::kLatchedOutput);
  const auto received = maps.take(kPatience);
  ASSERT_TRUE(received && *received);
  EXPECT_EQ((**received)->data._buffer[0], 100);
}

TEST_F(DdsPublisherTest, LimitsHowOftenAPathIsSent) {
  auto paths = listen<idl::Path>("slamfuse/path/laser");
  options_.path_period = 3600.0;
  auto publishing = publisher();
  for (int i = 0; i < 50; ++i) publishing->on_estimate(estimate(PoseSource::kLaser, i, kStamp + i));
  publishing->finish({.laser = {{kStamp, {7.0, 0.0, 0.0}}}});
  const auto first = paths.take(kPatience);
  ASSERT_TRUE(first && *first);
  EXPECT_EQ((**first)->poses._length, 1u);
  const auto last = paths.take(kPatience);
  ASSERT_TRUE(last && *last);
  EXPECT_EQ((**last)->poses._buffer[0].pose.position.x, 7.0);
  EXPECT_FALSE(*paths.take(100ms));
}

TEST_F(DdsPublisherTest, HoldsTheVisualPathBackUntilItIsAligned) {
  auto paths = listen<idl::Path>("slamfuse/path/visual");
  options_.path_period = 0.0;
  std::optional<fusion::Alignment> alignment;
  auto publishing = publisher([&] { return alignment; });
  publishing->on_estimate(estimate(PoseSource::kVisual, 1.0, kStamp));
  alignment = fusion::Alignment();  // refused
  publishing->on_estimate(estimate(PoseSource::kVisual, 1.0, kStamp + 1));
  EXPECT_FALSE(*paths.take(100ms));
  alignment->accepted = true;
  publishing->on_estimate(estimate(PoseSource::kVisual, 1.0, kStamp + 2));
  const auto path = paths.take(kPatience);
  ASSERT_TRUE(path && *path);
  EXPECT_EQ((**path)->poses._length, 3u);
}

TEST_F(DdsPublisherTest, NeverMixesEpochsNorShowsLostPoses) {
  auto paths = listen<idl::Path>("slamfuse/path/laser");
  options_.path_period = 0.0;
  auto publishing = publisher();
  publishing->on_estimate(estimate(PoseSource::kLaser, 1.0, kStamp));
  auto lost = estimate(PoseSource::kLaser, 2.0, kStamp + 1);
  lost.state = common::TrackingState::kLost;
  publishing->on_estimate(lost);
  auto next = estimate(PoseSource::kLaser, 3.0, kStamp + 2);
  next.map_epoch = 1;
  publishing->on_estimate(next);
  ASSERT_TRUE(*paths.take(kPatience));
  const auto second = paths.take(kPatience);
  ASSERT_TRUE(second && *second);
  ASSERT_EQ((**second)->poses._length, 1u);
  EXPECT_EQ((**second)->poses._buffer[0].pose.position.x, 3.0);
}

TEST_F(DdsPublisherTest, SendsTheLatestVerdictsTogether) {
  auto statuses = listen<idl::FusionStatus>("slamfuse/status");
  auto publishing = publisher();
  publishing->on_status({kStamp, PoseSource::kLaser, fusion::Verdict::kTracking, 1.0, {}});
  publishing->on_status({kStamp, PoseSource::kFused, fusion::Verdict::kSuspect, 0.5, {"they disagree"}});
  ASSERT_TRUE(*statuses.take(kPatience));
  const auto status = statuses.take(kPatience);
  ASSERT_TRUE(status && *status);
  EXPECT_EQ((**status)->state, 1);
  EXPECT_EQ(idl::text_of((**status)->reasons._buffer[0]), "they disagree");
  EXPECT_EQ((**status)->sources._length, 1u);
}

TEST_F(DdsPublisherTest, DoesNotWaitLongForListenersThatDoNotCome) {
  options_.reader_wait = 0.1;
  const auto started = std::chrono::steady_clock::now();
  auto publishing = publisher();
  publishing->finish({});
  EXPECT_LT(std::chrono::steady_clock::now() - started, 3s);
}

}  // namespace
}  // namespace slamfuse::service
