// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/visual_slam.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <limits>
#include <span>

#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "service/temporary_folder.hpp"

namespace slamfuse::visual_slam {
namespace {

using common::PoseEstimate;
using common::TrackingState;

/// The first seconds of the demo recording, and modules to run them through.
class VisualSlamTest : public ::testing::Test {
 protected:
  static constexpr double kSeconds = 6.0;
  static constexpr double kLongSeconds = 16.0;  // until there is a map to find oneself in

  static void SetUpTestSuite() {
    auto recording = common::open_recording(std::filesystem::path(SLAMFUSE_DATA_DIR) / "flat");
    ASSERT_TRUE(recording) << recording.error().message;
    cameras_ = new std::map<std::string, common::CameraCalibration>((*recording)->info().calibration.cameras);
    messages_ = new std::vector<common::SensorMessage>();
    long_messages_ = new std::vector<common::SensorMessage>();
    const common::Nanoseconds end = (*recording)->info().first_stamp + common::from_seconds(kLongSeconds);
    const common::Nanoseconds soon = (*recording)->info().first_stamp + common::from_seconds(kSeconds);
    while (true) {
      auto item = (*recording)->next();
      ASSERT_TRUE(item) << item.error().message;
      if (!*item) break;
      const auto* message = std::get_if<common::SensorMessage>(&**item);
      if (message == nullptr) continue;
      if (common::stamp_of(*message) > end) break;
      if (std::holds_alternative<common::LaserScan>(*message)) continue;
      long_messages_->push_back(*message);
      if (common::stamp_of(*message) <= soon) messages_->push_back(*message);
    }
  }

  static void TearDownTestSuite() {
    delete cameras_;
    delete messages_;
    delete long_messages_;
  }

  static std::unique_ptr<VisualSlam> make(int threads = 1) {
    auto slam = VisualSlam::create({}, *cameras_, 1, threads);
    EXPECT_TRUE(slam);
    return std::move(*slam);
  }

  /// The message, with the pixels of an image replaced by `gray`.
  static common::SensorMessage painted(common::SensorMessage message, std::uint8_t gray) {
    if (auto* image = std::get_if<common::Image>(&message)) {
      image->pixels = std::make_shared<const std::vector<std::uint8_t>>(image->pixels->size(), gray);
    }
    return message;
  }

  static std::vector<PoseEstimate> run(VisualSlam& slam, std::span<const common::SensorMessage> messages) {
    std::vector<PoseEstimate> estimates;
    for (const common::SensorMessage& message : messages) {
      const common::ProcessResult result = slam.process(message);
      EXPECT_FALSE(result.rejected) << *result.rejected;
      if (result.estimate) estimates.push_back(*result.estimate);
    }
    return estimates;
  }

  static std::map<std::string, common::CameraCalibration>* cameras_;
  static std::vector<common::SensorMessage>* messages_;
  static std::vector<common::SensorMessage>* long_messages_;
};

std::map<std::string, common::CameraCalibration>* VisualSlamTest::cameras_ = nullptr;
std::vector<common::SensorMessage>* VisualSlamTest::messages_ = nullptr;
std::vector<common::SensorMessage>* VisualSlamTest::long_messages_ = nullptr;

bool same(const PoseEstimate& a, const PoseEstimate& b) {
  return a.stamp == b.stamp && a.pose.vector() == b.pose.vector() && a.covariance == b.covariance &&
         a.state == b.state && a.health.inliers == b.health.inliers;
}

TEST_F(VisualSlamTest, EveryImageMakesAnEstimateAtItsOwnStamp) {
  const auto slam = make();

  const std::vector<PoseEstimate> estimates = run(*slam, *messages_);

  std::size_t images = 0;
  for (const auto& message : *messages_) images += std::holds_alternative<common::Image>(message) ? 1 : 0;
  ASSERT_EQ(estimates.size(), images);
  EXPECT_EQ(estimates.back().state, TrackingState::kTracking);
  EXPECT_GT(estimates.back().health.inliers.value(), 15);
  EXPECT_EQ(slam->final_trajectory().size(), estimates.size());
  EXPECT_EQ(slam->final_trajectory().back().stamp, estimates.back().stamp);
  EXPECT_GT(slam->landmarks().size(), 20U);
  EXPECT_EQ(slam->landmarks().front().descriptor.size() % 32, 0U);
}

TEST_F(VisualSlamTest, RepeatingARunAndChangingTheThreadsChangesNothing) {
  const auto first = make(1), second = make(2);

  const std::vector<PoseEstimate> a = run(*first, *messages_);
  const std::vector<PoseEstimate> b = run(*second, *messages_);

  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(same(a[i], b[i])) << i;
}

TEST_F(VisualSlamTest, BlackAndWhiteImagesAreSurvivedWithoutFalseConfidence) {
  for (const std::uint8_t gray : {std::uint8_t{0}, std::uint8_t{255}}) {
    const auto slam = make();
    std::vector<common::SensorMessage> messages(messages_->begin(), messages_->begin() + messages_->size() / 3);
    for (std::size_t i = messages.size(); i < messages_->size(); ++i)
      messages.push_back(painted((*messages_)[i], gray));

    const std::vector<PoseEstimate> estimates = run(*slam, messages);

    EXPECT_EQ(estimates[estimates.size() / 4].state, TrackingState::kTracking);
    EXPECT_EQ(estimates.back().state, TrackingState::kLost);
    EXPECT_GT(estimates.back().covariance.trace(), 2.0 * estimates[estimates.size() / 3].covariance.trace());
  }
}

TEST_F(VisualSlamTest, AFrozenPictureWhileDrivingIsNotBelieved) {
  const auto slam = make();
  const std::size_t freeze = messages_->size() / 2;
  std::map<std::string, common::Image> frozen;
  std::vector<common::SensorMessage> messages;
  for (std::size_t i = 0; i < messages_->size(); ++i) {
    messages.push_back((*messages_)[i]);
    auto* image = std::get_if<common::Image>(&messages.back());
    if (image == nullptr) continue;
    if (i < freeze) frozen[image->sensor] = *image;
    image->pixels = frozen[image->sensor].pixels;
  }

  const std::vector<PoseEstimate> estimates = run(*slam, messages);

  EXPECT_NE(estimates.back().state, TrackingState::kTracking);
}

TEST_F(VisualSlamTest, FindsItselfInASavedMapAndLeavesItAsItIs) {
  const auto mapping = make();
  const std::vector<PoseEstimate> mapped = run(*mapping, *long_messages_);
  const std::vector<common::Landmark> map = mapping->landmarks();
  const auto slam = make();
  ASSERT_TRUE(slam->load(map, MapUse::kLocalise));

  const std::vector<PoseEstimate> found = run(*slam, *long_messages_);

  EXPECT_EQ(found.front().state, TrackingState::kLost);
  EXPECT_EQ(found.front().map_epoch, 0U);
  int tracking = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].state != TrackingState::kTracking) continue;
    ++tracking;
    EXPECT_LT((found[i].pose.translation() - mapped[i].pose.translation()).norm(), 0.1);
  }
  EXPECT_GT(tracking, static_cast<int>(found.size()) * 3 / 4);
  const std::vector<common::Landmark> kept = slam->landmarks();
  ASSERT_EQ(kept.size(), map.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].position, map[i].position);
    EXPECT_EQ(kept[i].observations, map[i].observations);
    EXPECT_EQ(kept[i].views.size(), map[i].views.size());
  }

  slam->execute(common::Reset{});
  EXPECT_EQ(slam->landmarks().size(), map.size()) << "the map is the user's";
}

TEST_F(VisualSlamTest, ContinuesASavedMap) {
  const auto mapping = make();
  run(*mapping, std::span(*long_messages_).first(long_messages_->size() / 2));
  const auto slam = make();
  ASSERT_TRUE(slam->load(mapping->landmarks(), MapUse::kContinue));

  const std::vector<PoseEstimate> found = run(*slam, *long_messages_);

  EXPECT_EQ(found.back().state, TrackingState::kTracking);
  EXPECT_GT(slam->landmarks().size(), mapping->landmarks().size());
}

TEST_F(VisualSlamTest, RelocaliseSearchesTheWholeMapForARobotThatWasCarriedBack) {
  const auto slam = make();
  const std::vector<PoseEstimate> before = run(*slam, *long_messages_);
  slam->execute(common::Relocalise{});
  std::vector<common::SensorMessage> again = *long_messages_;
  for (common::SensorMessage& message : again) {
    std::visit([](auto& one) { one.stamp += common::from_seconds(kLongSeconds + 1.0); }, message);
  }

  const std::vector<PoseEstimate> after = run(*slam, again);

  ASSERT_EQ(after.size(), before.size());
  EXPECT_EQ(after.front().state, TrackingState::kLost);
  EXPECT_EQ(after.front().map_epoch, before.back().map_epoch);
  EXPECT_EQ(after.back().state, TrackingState::kTracking);
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (after[i].state != TrackingState::kTracking) continue;
    EXPECT_LT((after[i].pose.translation() - before[i].pose.translation()).norm(), 0.15) << i;
  }
}

TEST_F(VisualSlamTest, RefusesASavedMapItCannotFindItselfIn) {
  const auto slam = make();
  common::Landmark landmark;
  landmark.id = 4;
  EXPECT_FALSE(slam->load({landmark}, MapUse::kLocalise)) << "no views";
  landmark.views.emplace_back();
  EXPECT_FALSE(slam->load({landmark, landmark}, MapUse::kLocalise)) << "a number twice";
  landmark.position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(slam->load({landmark}, MapUse::kLocalise)) << "no place";
}

/// Without wheel odometry.
class FreeVisualSlamTest : public VisualSlamTest {
 protected:
  static std::unique_ptr<VisualSlam> make_free() {
    VisualSlamOptions options;
    options.motion.model = MotionModelKind::kConstantVelocity;
    return std::move(*VisualSlam::create(options, *cameras_, 1, 1));
  }
};

TEST_F(FreeVisualSlamTest, FollowsThePathUpToAScaleWithoutWantingOdometry) {
  const auto slam = make_free();
  common::Trajectory2 odometry, estimated;
  std::vector<common::SensorMessage> images;
  for (const auto& message : *messages_) {
    if (slam->wants(message)) images.push_back(message);
    if (const auto* wheels = std::get_if<common::WheelOdometry>(&message)) {
      odometry.push_back({wheels->stamp, wheels->pose});
    }
  }

  for (const PoseEstimate& estimate : run(*slam, images)) {
    EXPECT_EQ(estimate.state, TrackingState::kTracking);
    estimated.push_back({estimate.stamp, estimate.pose});
  }

  ASSERT_GT(images.size(), 40U);
  EXPECT_LT(images.size(), messages_->size());
  const auto accuracy = common::evaluate_trajectory(
      estimated, odometry, {.align = common::EvaluationAlignment::kSim2, .T_reference_estimate = {}});
  ASSERT_TRUE(accuracy);
  EXPECT_LT(accuracy->ate_rmse_m, 0.1);
}

TEST_F(FreeVisualSlamTest, IsLostWhenBlind) {
  const auto slam = make_free();
  std::vector<common::SensorMessage> images;
  for (const auto& message : *messages_) {
    if (slam->wants(message)) images.push_back(message);
  }
  for (std::size_t i = images.size() / 3; i < images.size(); ++i) images[i] = painted(images[i], 0);

  const std::vector<PoseEstimate> estimates = run(*slam, images);

  EXPECT_EQ(estimates[images.size() / 4].state, TrackingState::kTracking);
  EXPECT_EQ(estimates.back().state, TrackingState::kLost);
}

TEST_F(VisualSlamTest, UnusableImagesAreRejectedWithTheReason) {
  const auto slam = make();
  const auto is_image = [](const auto& message) { return std::holds_alternative<common::Image>(message); };
  const auto image = std::get<common::Image>(*std::find_if(messages_->begin(), messages_->end(), is_image));

  const common::ProcessResult too_early = slam->process(image);
  run(*slam, std::span(*messages_).first(20));
  common::Image small = image;
  small.width /= 2;
  common::Image stranger = image;
  stranger.sensor = "cam9";

  ASSERT_TRUE(too_early.rejected);
  EXPECT_NE(too_early.rejected->find("wheel odometry"), std::string::npos);
  EXPECT_NE(slam->process(image).rejected.value().find("not after"), std::string::npos);
  EXPECT_NE(slam->process(small).rejected.value().find("320"), std::string::npos);
  EXPECT_NE(slam->process(stranger).rejected.value().find("cam9"), std::string::npos);
  EXPECT_FALSE(slam->wants(stranger));
}

TEST_F(VisualSlamTest, SetPoseMovesTheEstimateAndResetStartsANewEpoch) {
  const auto slam = make();
  const std::size_t most = messages_->size() / 2;
  const std::vector<PoseEstimate> before = run(*slam, std::span(*messages_).first(most));

  slam->execute(common::SetPose{{5.0, -3.0, 1.0}, 0.01 * Eigen::Matrix3d::Identity()});
  const std::vector<PoseEstimate> moved = run(*slam, std::span(*messages_).subspan(most, 10));
  slam->execute(common::Reset{});
  const std::vector<PoseEstimate> fresh = run(*slam, std::span(*messages_).subspan(most + 10));

  EXPECT_NEAR(moved.front().pose.x, 5.0, 0.3);
  EXPECT_EQ(moved.front().map_epoch, 0U);
  ASSERT_FALSE(fresh.empty());
  EXPECT_EQ(fresh.front().map_epoch, 1U);
  ASSERT_FALSE(fresh.front().events.empty());
  EXPECT_EQ(fresh.front().events.front().kind, "map_reset");
  EXPECT_LT(fresh.front().pose.translation().norm(), 0.2);
  EXPECT_EQ(slam->final_trajectory().size(), before.size() + moved.size() + fresh.size());
}

TEST_F(VisualSlamTest, TheMapStaysWithinItsLimit) {
  VisualSlamOptions options;
  options.map.max_landmarks = 60;
  options.map.max_archived = 10;
  auto slam = VisualSlam::create(options, *cameras_, 1, 1);
  ASSERT_TRUE(slam);

  run(**slam, *messages_);

  EXPECT_LE((*slam)->landmarks().size(), 130U);  // those in view are never dropped: 60 an image, two cameras
}

/// With SIFT or ORB features.
class VisualFrontEndTest : public VisualSlamTest, public ::testing::WithParamInterface<FrontEndKind> {};

TEST_P(VisualFrontEndTest, TracksTheDemo) {
  VisualSlamOptions options;
  options.front_end.kind = GetParam();
  auto slam = VisualSlam::create(options, *cameras_, 1, 2);
  ASSERT_TRUE(slam);

  const std::vector<PoseEstimate> estimates = run(**slam, std::span(*messages_).first(messages_->size() / 2));

  for (const PoseEstimate& estimate : estimates) EXPECT_EQ(estimate.state, TrackingState::kTracking);
  EXPECT_GT(estimates.back().health.inliers.value(), 10);
}

INSTANTIATE_TEST_SUITE_P(All, VisualFrontEndTest, ::testing::Values(FrontEndKind::kSift, FrontEndKind::kOrb),
                         [](const auto& variant) { return variant.param == FrontEndKind::kSift ? "Sift" : "Orb"; });

TEST_F(VisualSlamTest, SelectedFeaturesCarryTheNameOfTheirObjectIntoTheMap) {
  const auto is_image = [](const auto& message) { return std::holds_alternative<common::Image>(message); };
  const auto first = std::get<common::Image>(*std::find_if(messages_->begin(), messages_->end(), is_image));
  const service::TemporaryFolder folder;
  service::put(folder / "view.pgm", "P5\n" + std::to_string(first.width) + " " + std::to_string(first.height) +
                                        "\n255\n" + std::string(first.pixels->begin(), first.pixels->end()));
  VisualSlamOptions options;
  options.selection.strategy = SelectionStrategy::kBoth;
  options.selection.objects = folder.path().string();
  options.selection.object_features = FeatureKind::kOrb;
  auto slam = VisualSlam::create(options, *cameras_, 1, 1);
  ASSERT_TRUE(slam) << slam.error().message;

  run(**slam, *messages_);

  std::size_t named = 0;
  for (const common::Landmark& landmark : (*slam)->landmarks()) named += landmark.object == "view" ? 1 : 0;
  EXPECT_GT(named, 3U);
  EXPECT_LT(named, (*slam)->landmarks().size());
}

TEST_F(VisualSlamTest, SelectionByObjectsWithoutPicturesOfThemIsRefused) {
  VisualSlamOptions options;
  options.selection.strategy = SelectionStrategy::kTopDown;
  const auto slam = VisualSlam::create(options, *cameras_, 1, 1);
  ASSERT_FALSE(slam);
  EXPECT_NE(slam.error().message.find("visual.selection.objects"), std::string::npos);
}

TEST(VisualSlamCreate, RefusesToStartWithoutUsableCameras) {
  EXPECT_FALSE(VisualSlam::create({}, {}, 1, 1));
  const auto no_size = VisualSlam::create({}, {{"cam0", {}}}, 1, 1);
  ASSERT_FALSE(no_size);
  EXPECT_NE(no_size.error().message.find("cam0"), std::string::npos);
}

/// What a drive with wrong stamps gives; arrival stays as it was.
class WrongStampsTest : public VisualSlamTest {
 protected:
  /// `reset_at` [s] from the start, if any.
  void drive(VisualSlam& slam, double offset, std::optional<double> reset_at = {}) {
    const common::Nanoseconds start = common::stamp_of(long_messages_->front());
    for (common::SensorMessage message : *long_messages_) {
      if (reset_at && common::stamp_of(message) > start + common::from_seconds(*reset_at)) {
        slam.execute(common::Reset{});
        reset_at.reset();
      }
      if (auto* image = std::get_if<common::Image>(&message)) image->stamp += common::from_seconds(offset);
      const auto result = slam.process(message);
      if (!result.estimate) continue;
      told_.push_back(result.estimate->stamp);
      for (const auto& event : result.estimate->events) corrections_ += event.kind == "clock_offset" ? 1 : 0;
    }
    EXPECT_TRUE(std::is_sorted(told_.begin(), told_.end()));
    EXPECT_GE(corrections_, 2) << "of both cameras";
    const common::Trajectory2 path = slam.final_trajectory();
    EXPECT_TRUE(std::is_sorted(path.begin(), path.end(),
                               [](const auto& before, const auto& after) { return before.stamp < after.stamp; }));
  }
  static double error(const common::Trajectory2& path) {
    const auto truth = common::read_ground_truth(std::filesystem::path(SLAMFUSE_DATA_DIR) / "flat");
    const auto accuracy = common::evaluate_trajectory(path, *truth, {});
    return accuracy ? accuracy->ate_rmse_m : std::numeric_limits<double>::infinity();
  }

  std::vector<common::Nanoseconds> told_;
  int corrections_ = 0;
};

TEST_F(WrongStampsTest, TheMapIsMadeAnewFromTheBeginning) {
  for (const double offset : {0.2, -0.2}) {
    told_.clear();
    const auto slam = make();
    drive(*slam, offset);
    const common::Trajectory2 path = slam->final_trajectory();
    ASSERT_FALSE(path.empty());
    EXPECT_LT(path.front().stamp, common::stamp_of(long_messages_->front()) + common::from_seconds(0.5));
    EXPECT_LT(error(path), 0.04) << offset;
  }
}

TEST_F(WrongStampsTest, OfOneCameraAloneAreFoundToo) {
  std::map<std::string, common::CameraCalibration> one = {*cameras_->begin()};
  const auto slam = *VisualSlam::create({}, one, 1, 1);
  corrections_ = 1;  // there is no other camera to be corrected
  drive(*slam, 0.2);
  EXPECT_LT(error(slam->final_trajectory()), 0.06);
}

TEST_F(WrongStampsTest, ImagesFromBeforeAResetAreNotUsedAgain) {
  const auto slam = make();
  drive(*slam, 0.2, 4.0);
  const common::Trajectory2 path = slam->final_trajectory();
  EXPECT_LT(path.front().stamp, common::stamp_of(long_messages_->front()) + common::from_seconds(0.5))
      << "the path from before it stays";
  const common::Nanoseconds reset_at = common::stamp_of(long_messages_->front()) + common::from_seconds(4.5);
  common::Trajectory2 since;
  std::copy_if(path.begin(), path.end(), std::back_inserter(since),
               [&](const auto& pose) { return pose.stamp > reset_at; });
  EXPECT_LT(error(since), 0.04);
  EXPECT_LT(since.front().pose.translation().norm(), 0.3) << "its map begins there";
}

TEST_F(WrongStampsTest, AMapThatIsContinuedIsNotLost) {
  const auto before = make();
  for (const common::SensorMessage& message : *long_messages_) before->process(message);
  const std::vector<common::Landmark> map = before->landmarks();
  ASSERT_GT(map.size(), 50u);
  const auto slam = make();
  ASSERT_TRUE(slam->load(map, MapUse::kContinue));
  drive(*slam, 0.2);
  const std::vector<common::Landmark> continued = slam->landmarks();
  const auto is_old = [&map](const common::Landmark& landmark) {
    return std::any_of(map.begin(), map.end(), [&landmark](const common::Landmark& old) {
      return old.id == landmark.id && (old.position - landmark.position).norm() < 0.2;
    });
  };
  EXPECT_GT(2 * std::count_if(continued.begin(), continued.end(), is_old), static_cast<std::ptrdiff_t>(map.size()));
}

TEST_F(WrongStampsTest, WithoutImagesKeptTheMapBeginsWithTheNext) {
  VisualSlamOptions options;
  options.image_clock.kept_images = 0.0;
  const auto slam = *VisualSlam::create(options, *cameras_, 1, 1);
  drive(*slam, 0.2);
  EXPECT_FALSE(slam->landmarks().empty());
}

}  // namespace
}  // namespace slamfuse::visual_slam
