// SPDX-License-Identifier: BSD-3-Clause
// `slamfuse serve` and a robot that speaks Fast DDS: its scans and pictures drive the service, and it understands what
// the service publishes.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/recording.hpp"
#include "common/trajectory.hpp"
#include "common/trajectory_evaluation.hpp"
#include "common/tum.hpp"
#include "idl/scoped_environment.hpp"
#include "service/map_bundle.hpp"
#include "system/child_process.hpp"

namespace slamfuse {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using system::appears;
using system::exit_status_of;
using system::start;

const std::string kFlat = SLAMFUSE_DATA_DIR "/flat";

// One run for all tests.
class ForeignClient : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("slamfuse-foreign-" + std::to_string(getpid()));
    fs::create_directories(folder_);
    // A domain of its own: Fast DDS knows no discovery tags.
    const idl::ScopedEnvironment domain("ROS_DOMAIN_ID", std::to_string(100 + getpid() % 100).c_str());
    const pid_t service = start({SLAMFUSE_PROGRAM, "serve", "-o", folder_ / "out", "--readout", "cam0=0.016",
                                 "--readout", "cam1=0.016", "--set", "service.save_interval=2"});
    const pid_t robot = start({FAST_DDS_CLIENT, kFlat, "20", "1", folder_});
    played_ = appears(folder_ / "played", 90s);
    kill(service, SIGTERM);
    serve_status_ = exit_status_of(service);
    robot_status_ = exit_status_of(robot);
    std::ifstream file(folder_ / "messages.txt");
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string kind;
      words >> kind;
      messages_[kind].push_back(line.substr(kind.size() + 1));
    }
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }

  void SetUp() override {
    ASSERT_TRUE(played_);
    ASSERT_EQ(serve_status_, 0);
    ASSERT_EQ(robot_status_, 0);
  }

  static inline fs::path folder_;
  static inline bool played_ = false;
  static inline int serve_status_ = -1;
  static inline int robot_status_ = -1;
  static inline std::map<std::string, std::vector<std::string>> messages_;
};

TEST_F(ForeignClient, PosesAreThoseOfTheResults) {
  const auto fused = common::read_trajectory(folder_ / "out/fused.tum");
  ASSERT_TRUE(fused);
  // Published stamps rise: of two poses of one stamp, by odometry and by a picture, the first one went out.
  std::multimap<common::Nanoseconds, common::Pose2> by_stamp;
  for (const auto& pose : common::to_planar(*fused)) by_stamp.emplace(pose.stamp, pose.pose);
  ASSERT_GT(messages_["pose"].size(), 200u);
  std::size_t found = 0;
  for (const auto& line : messages_["pose"]) {
    std::istringstream words(line);
    common::Nanoseconds stamp = 0;
    std::string frame;
    double x = 0.0;
    double y = 0.0;
    words >> stamp >> frame >> x >> y;
    EXPECT_EQ(frame, "map");
    const auto pose = by_stamp.lower_bound(stamp);
    if (pose == by_stamp.end() || pose->first != stamp) continue;
    ++found;
    EXPECT_NEAR(x, pose->second.x, 1e-6);
    EXPECT_NEAR(y, pose->second.y, 1e-6);
  }
  EXPECT_GT(found, messages_["pose"].size() * 9 / 10);
  EXPECT_GT(messages_["tf"].size(), 200u);
  EXPECT_NE(messages_["tf"].front().find(" map odom "), std::string::npos);
}

TEST_F(ForeignClient, ItsScansAndPicturesMakeAGoodMap) {
  const auto estimate = common::read_trajectory(folder_ / "out/fused.tum");
  const auto truth = common::read_ground_truth(kFlat);
  ASSERT_TRUE(estimate && truth);
  const auto accuracy = common::evaluate_trajectory(common::to_planar(*estimate), *truth, {});
  ASSERT_TRUE(accuracy);
  std::printf("ATE %.4f m\n", accuracy->ate_rmse_m);
  EXPECT_LT(accuracy->ate_rmse_m, 0.15);  // 0.013 m where nothing is dropped; a busy machine drops
  EXPECT_TRUE(fs::exists(folder_ / "out/visual.tum"));
}

TEST_F(ForeignClient, ALateReaderGetsTheMap) {
  const auto bundle = service::read_map_bundle(folder_ / "out/map");
  ASSERT_TRUE(bundle && bundle->grid);
  ASSERT_FALSE(messages_["map"].empty());
  std::istringstream words(messages_["map"].back());  // the one at the end
  std::string frame;
  int width = 0;
  int height = 0;
  double resolution = 0.0;
  double x = 0.0;
  double y = 0.0;
  std::size_t occupied = 0;
  words >> frame >> width >> height >> resolution >> x >> y >> occupied;
  EXPECT_EQ(frame, "map");
  EXPECT_EQ(width, bundle->grid->width);
  EXPECT_EQ(height, bundle->grid->height);
  EXPECT_NEAR(resolution, bundle->grid->resolution, 1e-6);
  EXPECT_NEAR(x, bundle->grid->origin.x(), 1e-6);
  EXPECT_GT(occupied, 100u);
}

TEST_F(ForeignClient, StatusAndLandmarksAreUnderstood) {
  ASSERT_GT(messages_["status"].size(), 5u);
  std::istringstream words(messages_["status"].back());
  common::Nanoseconds stamp = 0;
  int state = -1;
  double score = -1.0;
  int sources = 0;
  words >> stamp >> state >> score >> sources;
  EXPECT_GE(state, 0);
  EXPECT_LE(state, 2);
  EXPECT_GE(score, 0.0);
  EXPECT_LE(score, 1.0);
  EXPECT_EQ(sources, 2);
  const auto bundle = service::read_map_bundle(folder_ / "out/map");
  ASSERT_TRUE(bundle);
  ASSERT_EQ(messages_["landmarks"].empty(), !bundle->summary.alignment);
  if (!bundle->summary.alignment) GTEST_SKIP() << "on this busy machine too few pictures were used to align the maps";
  std::istringstream landmarks(messages_["landmarks"].back());
  std::string frame;
  std::size_t points = 0;
  landmarks >> frame >> points;
  EXPECT_EQ(frame, "map");
  EXPECT_GT(points, 50u);
}

}  // namespace
}  // namespace slamfuse
