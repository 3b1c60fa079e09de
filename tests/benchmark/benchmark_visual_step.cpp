// SPDX-License-Identifier: BSD-3-Clause
// Time of a step: one image of each of two cameras, 400 features in each, 150 landmarks in the state.
//
//     benchmark_visual_step RECORDING [THREADS] [visual.key=value ...]
//
// The recording has two cameras, cam0 and cam1, of 640 x 480 pixels. For each front end two things are timed. Alone, it
// follows up to 400 features in each image and finds new ones for those it lost; SIFT and ORB find 400 keypoints. The
// whole module keeps 75 features an image, so that those of both cameras are the 150 landmarks of the state; all
// 150 are always being followed, which is the dearest case. The front end's share is in both figures, so their sum is
// more than what a step with 400 features of which 150 are in the state takes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "benchmark/visual_messages.hpp"
#include "common/config.hpp"
#include "visual_slam/front_end.hpp"
#include "visual_slam/visual_slam.hpp"

namespace {

using namespace slamfuse;

constexpr int kFeatures = 400;   // in an image
constexpr int kLandmarks = 150;  // in the state
constexpr int kSteps = 80;       // timed

int fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return EXIT_FAILURE;
}

double wall_milliseconds() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// What steps took.
class Times {
 public:
  void start() {
    wall_start_ = wall_milliseconds();
    processor_start_ = processor_milliseconds();
  }
  void stop() {
    wall_.push_back(wall_milliseconds() - wall_start_);
    processor_ += processor_milliseconds() - processor_start_;
  }
  /// Ends a line.
  void print() {
    std::sort(wall_.begin(), wall_.end());
    std::printf("%6.1f %6.1f %6.1f %6.1f\n", wall_[wall_.size() / 2], wall_[wall_.size() * 95 / 100], wall_.back(),
                processor_ / static_cast<double>(wall_.size()));
    std::fflush(stdout);
  }

 private:
  double wall_start_ = 0.0, processor_start_ = 0.0, processor_ = 0.0;
  std::vector<double> wall_;
};

cv::Mat picture_of(const common::Image& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data())};
}

/// Images of cam0 and cam1 in turn.
std::vector<std::pair<const common::Image*, const common::Image*>> steps_of(const VisualMessages& recording) {
  std::map<std::string, std::vector<const common::Image*>> images;
  for (const common::SensorMessage& message : recording.messages) {
    if (const auto* image = std::get_if<common::Image>(&message)) images[image->sensor].push_back(image);
  }
  std::vector<std::pair<const common::Image*, const common::Image*>> steps;
  for (std::size_t i = 0; i < kSteps && i < std::min(images["cam0"].size(), images["cam1"].size()); ++i) {
    steps.emplace_back(images["cam0"][i], images["cam1"][i]);
  }
  return steps;
}

void time_front_end(const char* name, const visual_slam::FrontEndOptions& options, const VisualMessages& recording) {
  const auto front_end = visual_slam::make_front_end(options, 2);
  std::vector<std::vector<visual_slam::ExpectedFeature>> expected(2);
  Times times;
  double followed = 0.0;
  const auto steps = steps_of(recording);
  for (const auto& [left, right] : steps) {
    times.start();
    for (std::size_t camera = 0; camera < 2; ++camera) {
      const cv::Mat picture = picture_of(camera == 0 ? *left : *right);
      std::vector<Eigen::Vector2d> pixels;
      for (const auto& found : front_end->follow(camera, picture, expected[camera])) pixels.push_back(found.pixel);
      followed += static_cast<double>(pixels.size()) / (2.0 * static_cast<double>(steps.size()));
      const auto more = front_end->detect(camera, pixels, kFeatures - static_cast<int>(pixels.size()), cv::Mat());
      pixels.insert(pixels.end(), more.begin(), more.end());
      expected[camera].clear();
      for (const Eigen::Vector2d& pixel : pixels) expected[camera].push_back({0, pixel, pixel});
    }
    times.stop();
  }
  std::printf("%-15s front end alone, %3.0f of %d followed ", name, followed, kFeatures);
  times.print();
}

common::Result<void> time_module(const char* name, const visual_slam::VisualSlamOptions& options,
                                 const VisualMessages& recording, int threads) {
  auto slam = visual_slam::VisualSlam::create(options, recording.cameras, 1, threads);
  if (!slam) return tl::unexpected(slam.error());
  Times times;
  int images = 0, inliers = 0;
  for (const common::SensorMessage& message : recording.messages) {
    const auto* image = std::get_if<common::Image>(&message);
    if (image != nullptr && images % 2 == 0) times.start();
    const common::ProcessResult result = (*slam)->process(message);
    if (image == nullptr) continue;
    if (result.estimate) inliers += result.estimate->health.inliers.value_or(0);
    if (++images % 2 == 0) times.stop();
    if (images == 2 * kSteps) break;
  }
  std::printf("%-15s whole module, %3d accepted an image       ", name, inliers / std::max(1, images));
  times.print();
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return fail("usage: benchmark_visual_step RECORDING [THREADS] [visual.key=value ...]");
  visual_slam::VisualSlamOptions options;
  options.front_end.keypoints_per_image = kFeatures;
  options.front_end.features_per_image = kLandmarks / 2;
  options.map.max_landmarks = kLandmarks;
  int threads = 2;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.find('=') == std::string::npos) {
      threads = std::atoi(argv[i]);
      continue;
    }
    const auto set = common::set_option(
        argument, [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) return fail(set.error().message);
  }
  const auto recording = read_visual_messages(argv[1], "cam0,cam1");
  if (!recording) return fail(recording.error().message);
  cv::setNumThreads(threads);
  std::printf("ms a step of two images, %d threads: median, 95 %%, largest; processor\n", threads);
  using visual_slam::DescriptorSearch;
  using visual_slam::FrontEndKind;
  struct Variant {
    const char* name;
    FrontEndKind kind;
    DescriptorSearch search;
  };
  for (const Variant& variant : {Variant{"shi_tomasi_klt", FrontEndKind::kShiTomasiKlt, DescriptorSearch::kComplete},
                                 Variant{"orb, complete", FrontEndKind::kOrb, DescriptorSearch::kComplete},
                                 Variant{"orb, flann", FrontEndKind::kOrb, DescriptorSearch::kFlann},
                                 Variant{"sift, complete", FrontEndKind::kSift, DescriptorSearch::kComplete},
                                 Variant{"sift, flann", FrontEndKind::kSift, DescriptorSearch::kFlann}}) {
    options.front_end.kind = variant.kind;
    options.front_end.search = variant.search;
    visual_slam::FrontEndOptions dense = options.front_end;
    dense.min_spacing = 6.0;  // else 400 find no room
    time_front_end(variant.name, dense, *recording);
    const auto timed = time_module(variant.name, options, *recording, threads);
    if (!timed) return fail(timed.error().message);
  }
  return EXIT_SUCCESS;
}
