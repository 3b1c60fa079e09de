// SPDX-License-Identifier: BSD-3-Clause
#include "idl/security.hpp"

#include <chrono>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "idl/private_domain.hpp"
#include "idl/reader.hpp"
#include "idl/writer.hpp"

namespace slamfuse::idl {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// Who must not hear whom is tested between processes (system.record): within one Cyclone hands messages on directly.
class Security : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = fs::temp_directory_path() / ("slamfuse-keystore-" + std::to_string(getpid()));
    made_ = make("ours", "slamfuse viewer");
  }
  static void TearDownTestSuite() { fs::remove_all(folder_); }
  void SetUp() override { ASSERT_TRUE(made_) << "scripts/keystore failed: is openssl installed?"; }

  static bool make(const std::string& store, const std::string& enclaves) {
    fs::create_directories(folder_);
    const std::string command =
        fmt::format("{} {} {} > /dev/null", SLAMFUSE_KEYSTORE_SCRIPT, (folder_ / store).string(), enclaves);
    return std::system(command.c_str()) == 0;
  }

  Participant join(const std::string& store, const std::string& enclave) const {
    DomainSettings settings = domain_.settings();
    settings.enclave = find_enclave(folder_ / store, enclave).value();
    return Participant::create(settings).value();
  }

  static bool hears(const Participant& listening, const Participant& speaking) {
    auto reader = Reader<PoseStamped>::create(listening, "pose", QosProfile::kTransformInput).value();
    auto writer = Writer<PoseStamped>::create(speaking, "pose", QosProfile::kOutput).value();
    if (!writer.wait_for_reader(2s)) return false;
    EXPECT_TRUE(writer.write(Message<PoseStamped>()));
    return reader.take(5s).value().has_value();
  }

  static inline fs::path folder_;
  static inline bool made_ = false;
  PrivateDomain domain_;
};

TEST_F(Security, ThoseOfAKeystoreHearEachOther) {
  EXPECT_TRUE(hears(join("ours", "/viewer"), join("ours", "/slamfuse")));
}

TEST_F(Security, TheEnvironmentOfRosTurnsItOn) {
  const ScopedEnvironment enable("ROS_SECURITY_ENABLE", "true");
  const ScopedEnvironment keystore("ROS_SECURITY_KEYSTORE", (folder_ / "ours").c_str());
  const auto settings = domain_from_environment(Network::kLoopback);
  ASSERT_TRUE(settings && settings->enclave);
  EXPECT_EQ(settings->enclave->name, "/slamfuse");
  const ScopedEnvironment other("ROS_SECURITY_ENCLAVE_OVERRIDE", "/viewer");
  EXPECT_EQ(domain_from_environment(Network::kLoopback)->enclave->name, "/viewer");
  const ScopedEnvironment nobody("ROS_SECURITY_ENCLAVE_OVERRIDE", "/nobody");
  EXPECT_THAT(domain_from_environment(Network::kLoopback).error().message, testing::HasSubstr("nobody/identity_ca"));
  const ScopedEnvironment nowhere("ROS_SECURITY_KEYSTORE", nullptr);
  EXPECT_THAT(domain_from_environment(Network::kLoopback).error().message, testing::HasSubstr("ROS_SECURITY_KEYSTORE"));
}

TEST_F(Security, TamperedPermissionsLetNobodyIn) {
  ASSERT_TRUE(make("tampered", "slamfuse"));
  const fs::path permissions = folder_ / "tampered/enclaves/slamfuse/permissions.p7s";
  std::string text;
  {
    std::ifstream file(permissions);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  text.replace(text.find("2035"), 4, "2036");
  std::ofstream(permissions) << text;
  DomainSettings settings = domain_.settings();
  settings.enclave = find_enclave(folder_ / "tampered", "slamfuse").value();
  EXPECT_FALSE(Participant::create(settings));
}

}  // namespace
}  // namespace slamfuse::idl
