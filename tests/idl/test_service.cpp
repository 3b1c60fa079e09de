// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "idl/private_domain.hpp"
#include "idl/service_client.hpp"
#include "idl/service_server.hpp"
#include "idl/waitset.hpp"

namespace slamfuse::idl {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 5s;

class ServiceTest : public testing::Test {
 protected:
  PrivateDomain domain_;
  Participant ours_ = Participant::create(domain_.settings()).value();
  Participant theirs_ = Participant::create(domain_.settings()).value();
};

TEST_F(ServiceTest, AnswersEachQuestionOfEachClient) {
  auto server = ServiceServer<SetMode>::create(ours_, "slamfuse/set_mode").value();
  auto waitset = WaitSet::create(ours_).value();
  ASSERT_TRUE(waitset.add(server.reader()));
  std::jthread serving([&](const std::stop_token& done) {
    while (!done.stop_requested()) {
      if (!waitset.wait(50ms)) continue;
      for (auto request = server.take(); request && *request; request = server.take()) {
        Message<SetMode::Response> response;
        response->success = text_of((**request)->mode) == "slam";
        assign(response->message, "heard " + text_of((**request)->mode));
        EXPECT_TRUE(server.answer(**request, response));
      }
    }
  });
  auto first = ServiceClient<SetMode>::create(theirs_, "slamfuse/set_mode").value();
  auto second = ServiceClient<SetMode>::create(theirs_, "slamfuse/set_mode").value();
  ASSERT_TRUE(first.wait_for_server(kPatience));
  ASSERT_TRUE(second.wait_for_server(kPatience));
  const auto ask = [](ServiceClient<SetMode>& client, const char* mode) {
    Message<SetMode::Request> request;
    assign(request->mode, mode);
    return client.call(request, kPatience).value().value();
  };
  const auto good = ask(first, "slam");
  EXPECT_TRUE(good->success);
  EXPECT_EQ(text_of(good->message), "heard slam");
  const auto bad = ask(second, "sleep");
  EXPECT_FALSE(bad->success);
  EXPECT_EQ(text_of(bad->message), "heard sleep");
  EXPECT_TRUE(ask(first, "slam")->success);
}

TEST_F(ServiceTest, PassesOverQuestionsThatItCouldNotAnswer) {
  auto server = ServiceServer<Trigger>::create(ours_, "slamfuse/save_map").value();
  auto writer = UntypedWriter::create(theirs_, descriptor<Trigger::Request>(), "rq/slamfuse/save_mapRequest",
                                      *make_qos(QosProfile::kOutput))
                    .value();
  ASSERT_TRUE(writer.wait_for_reader(kPatience));
  Message<Trigger::Request> request;
  ASSERT_TRUE(writer.write(&*request));
  ASSERT_TRUE(writer.wait_for_acknowledgments(kPatience));
  const auto taken = server.take();
  ASSERT_TRUE(taken);
  EXPECT_FALSE(*taken);
}

TEST_F(ServiceTest, AClientKnowsThatNobodyServes) {
  auto client = ServiceClient<Trigger>::create(theirs_, "slamfuse/save_map").value();
  EXPECT_FALSE(client.wait_for_server(50ms));
}

}  // namespace
}  // namespace slamfuse::idl
