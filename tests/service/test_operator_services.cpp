// SPDX-License-Identifier: BSD-3-Clause
#include "service/operator_services.hpp"

#include <chrono>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/service_client.hpp"
#include "idl/writer.hpp"

namespace slamfuse::service {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 5s;

// Writes down what is asked.
class FakeActions : public OperatorActions {
 public:
  Answer save_map() override { return note("save_map"); }
  Answer load_map(const std::string& path) override { return note("load_map " + path); }
  Answer set_mode(const std::string& mode) override {
    note("set_mode " + mode);
    return common::usage_error("mode '" + mode + "' is none");
  }
  Answer align_now() override { return note("align_now"); }
  Answer relocalise() override { return note("relocalise"); }
  Answer set_pose(const common::SetPose& pose) override {
    return note("set_pose " + std::to_string(static_cast<int>(pose.pose.x)));
  }

  std::vector<std::string> asked() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }

 private:
  Answer note(const std::string& what) {
    const std::lock_guard lock(mutex_);
    asked_.push_back(what);
    return "did " + what;
  }
  mutable std::mutex mutex_;
  std::vector<std::string> asked_;
};

class OperatorServicesTest : public testing::Test {
 protected:
  template <class Service, class Fill>
  std::pair<bool, std::string> call(const std::string& name, const Fill& fill) {
    auto client = idl::ServiceClient<Service>::create(participant_, name).value();
    EXPECT_TRUE(client.wait_for_server(kPatience));
    idl::Message<typename Service::Request> request;
    fill(*request);
    const auto response = client.call(request, kPatience).value();
    if (!response) return {false, "no answer"};
    return {(*response)->success, idl::text_of((*response)->message)};
  }
  std::pair<bool, std::string> trigger(const std::string& name) {
    return call<idl::Trigger>(name, [](auto&) {});
  }

  idl::PrivateDomain domain_;
  idl::Participant participant_ = idl::Participant::create(domain_.settings()).value();
  FakeActions actions_;
  std::unique_ptr<OperatorServices> services_ =
      OperatorServices::start(participant_, {}, actions_, [](const std::string&) {}).value();
};

TEST_F(OperatorServicesTest, HandsQuestionsOnAndAnswersInWords) {
  EXPECT_EQ(trigger("slamfuse/save_map"), std::pair(true, std::string("did save_map")));
  EXPECT_EQ(trigger("slamfuse/align_now"), std::pair(true, std::string("did align_now")));
  EXPECT_EQ(trigger("slamfuse/reinitialize_global_localization"), std::pair(true, std::string("did relocalise")));
  EXPECT_EQ(call<idl::LoadMap>("slamfuse/load_map", [](auto& request) { idl::assign(request.path, "maps/office"); }),
            std::pair(true, std::string("did load_map maps/office")));
  EXPECT_EQ(call<idl::SetMode>("slamfuse/set_mode", [](auto& request) { idl::assign(request.mode, "sleep"); }),
            std::pair(false, std::string("mode 'sleep' is none")));
}

TEST_F(OperatorServicesTest, TakesInitialPoses) {
  auto writer =
      idl::Writer<idl::PoseWithCovarianceStamped>::create(participant_, "initialpose", idl::QosProfile::kOutput)
          .value();
  ASSERT_TRUE(writer.wait_for_reader(kPatience));
  idl::Message<idl::PoseWithCovarianceStamped> message;
  idl::assign(message->header.frame_id, "map");
  message->pose.pose.orientation.w = 1.0;
  message->pose.pose.position.x = 7.0;
  ASSERT_TRUE(writer.write(message));
  for (int i = 0; i < 500 && actions_.asked().empty(); ++i) std::this_thread::sleep_for(10ms);
  EXPECT_THAT(actions_.asked(), testing::ElementsAre("set_pose 7"));
}

TEST(SetPoseOf, RefusesWhatIsNoPoseInTheMap) {
  const auto message = [](const char* frame) {
    idl::Message<idl::PoseWithCovarianceStamped> pose;
    idl::assign(pose->header.frame_id, frame);
    pose->pose.pose.orientation.w = 1.0;
    return pose;
  };
  EXPECT_TRUE(set_pose_of(*message("map")));
  EXPECT_TRUE(set_pose_of(*message("/map")));
  EXPECT_THAT(set_pose_of(*message("odom")).error().message, testing::HasSubstr("'odom'"));
  auto endless = message("map");
  endless->pose.pose.position.x = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(set_pose_of(*endless));
  auto no_rotation = message("map");
  no_rotation->pose.pose.orientation.w = 0.0;
  EXPECT_FALSE(set_pose_of(*no_rotation));
  auto negative = message("map");
  negative->pose.covariance[35] = -1.0;
  EXPECT_FALSE(set_pose_of(*negative));
}

}  // namespace
}  // namespace slamfuse::service
