// SPDX-License-Identifier: BSD-3-Clause
// What a listener that acknowledges nothing any more does to a writer. It is another process: within one, Cyclone hands
// messages on directly.
#include <chrono>
#include <filesystem>

#include <gtest/gtest.h>

#include "idl/writer.hpp"
#include "system/child_process.hpp"
#include "system/network.hpp"

namespace slamfuse::system {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

TEST(SlowReaders, NeverKeepAWriterWaiting) {
  const Network network;
  const auto participant = network.join();
  const fs::path folder = fs::temp_directory_path() / ("slamfuse-slow-" + std::to_string(getpid()));
  fs::create_directories(folder);
  auto images = idl::Writer<idl::Image>::create(participant, "image", idl::QosProfile::kOutput).value();
  const pid_t listener = start({SLAMFUSE_PROGRAM, "record", "-o", folder / "bag", "--topics", "/image"});
  EXPECT_TRUE(images.wait_for_reader(20s));
  idl::Message<idl::Image> image;
  idl::allocate(image->data, 100'000);
  EXPECT_TRUE(images.write(image));
  EXPECT_TRUE(images.wait_for_acknowledgments(10s));
  kill(listener, SIGSTOP);
  const auto begun = std::chrono::steady_clock::now();
  constexpr int kMessages = 50;  // five times the history
  for (int i = 0; i < kMessages; ++i) EXPECT_TRUE(images.write(image));
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begun;
  std::printf("%.2f ms a write\n", taken.count() / kMessages);
  EXPECT_FALSE(images.wait_for_acknowledgments(50ms)) << "the listener was to hang";
  kill(listener, SIGKILL);
  exit_status_of(listener);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace slamfuse::system
