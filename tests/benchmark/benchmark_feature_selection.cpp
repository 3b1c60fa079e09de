// SPDX-License-Identifier: BSD-3-Clause
// Seed 001's comparison of feature selections: error and time with none, bottom-up, top-down and both.
//
//     benchmark_feature_selection RECORDING CAMERAS OBJECT_RECORDING RUNS SECONDS [visual.key=value ...]
//
// Each run is SECONDS long; the first begins at the recording's start, the last ends at its end. Pictures
// of the known objects are cut out of images of another recording of the same place, sim/flat_second_visit, into a
// temporary folder. Time is the processor's, of one thread.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "benchmark/visual_messages.hpp"
#include "common/config.hpp"
#include "common/recording.hpp"
#include "common/trajectory_evaluation.hpp"
#include "visual_slam/feature_selection.hpp"
#include "visual_slam/visual_slam.hpp"

namespace {

using namespace slamfuse;

/// A rectangle of an image that shows a known object.
struct CutOut {
  const char* name;
  const char* camera;
  std::size_t image;
  cv::Rect place;
};

// Posters, pictures on the wall and a bookshelf in sim/flat_second_visit.
const CutOut kCutOuts[] = {
    {"theatre", "cam0", 70, {396, 5, 168, 229}},    {"concert", "cam0", 190, {388, 5, 176, 249}},
    {"festival", "cam0", 230, {453, 18, 142, 176}}, {"samples", "cam0", 30, {461, 101, 101, 85}},
    {"bookshelf", "cam0", 240, {143, 0, 434, 413}}, {"law", "cam0", 130, {330, 18, 133, 176}},
    {"room_204", "cam1", 130, {3, 13, 173, 244}},   {"robot_lab", "cam1", 170, {136, 3, 290, 282}},
    {"moon", "cam1", 200, {154, 25, 141, 169}},     {"rocket", "cam0", 80, {88, 113, 103, 71}},
    {"retina", "cam0", 100, {360, 23, 154, 168}},
};

constexpr double kRefillShare = 0.15;  // VisualSlam makes the region when so many features are missing

int fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  return EXIT_FAILURE;
}

/// A folder that goes away with the benchmark.
class CutOutFolder {
 public:
  CutOutFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "slamfuse-objects-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~CutOutFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  CutOutFolder(const CutOutFolder&) = delete;
  CutOutFolder& operator=(const CutOutFolder&) = delete;

  void fill(const VisualMessages& recording) {
    std::map<std::string, std::size_t> count;
    for (const common::SensorMessage& message : recording.messages) {
      const auto* image = std::get_if<common::Image>(&message);
      if (image == nullptr) continue;
      const std::size_t number = count[image->sensor]++;
      for (const CutOut& one : kCutOuts) {
        if (one.camera == image->sensor && one.image == number) write(one, *image);
      }
    }
  }
  std::string path() const { return path_.string(); }

 private:
  void write(const CutOut& one, const common::Image& image) const {
    std::ofstream file(path_ / (std::string(one.name) + ".pgm"), std::ios::binary);
    file << "P5\n" << one.place.width << ' ' << one.place.height << "\n255\n";
    for (int y = one.place.y; y < one.place.br().y; ++y) {
      file.write(reinterpret_cast<const char*>(image.pixels->data()) + y * image.width + one.place.x, one.place.width);
    }
  }

  std::filesystem::path path_;
};

struct Run {
  double ate = 0.0, final_ate = 0.0, coverage = 0.0, milliseconds = 0.0, features = 0.0, refilled = 0.0;
};

common::Result<Run> run(const VisualMessages& recording, const common::Trajectory2& truth,
                        const visual_slam::VisualSlamOptions& options, double from, double to) {
  auto slam = visual_slam::VisualSlam::create(options, recording.cameras, 1, 1);
  if (!slam) return tl::unexpected(slam.error());
  Run result;
  common::Trajectory2 online, part;
  int images = 0;
  const common::Nanoseconds begin = recording.first_stamp + common::from_seconds(from);
  const common::Nanoseconds end = recording.first_stamp + common::from_seconds(to);
  for (const common::StampedPose2& pose : truth) {
    if (pose.stamp >= begin && pose.stamp <= end) part.push_back(pose);
  }
  for (const common::SensorMessage& message : recording.messages) {
    if (common::stamp_of(message) < begin || common::stamp_of(message) > end) continue;
    const double start = processor_milliseconds();
    const common::ProcessResult done = (*slam)->process(message);
    result.milliseconds += processor_milliseconds() - start;
    if (!done.estimate) continue;
    ++images;
    const int accepted = done.estimate->health.inliers.value_or(0);
    result.features += accepted;
    if (accepted <= (1.0 - kRefillShare) * options.front_end.features_per_image) ++result.refilled;
    if (done.estimate->state != common::TrackingState::kLost) {
      online.push_back({done.estimate->stamp, done.estimate->pose});
    }
  }
  const common::EvaluationOptions se2{.align = common::EvaluationAlignment::kSe2, .T_reference_estimate = {}};
  const auto accuracy = common::evaluate_trajectory(online, part, se2);
  if (!accuracy) return tl::unexpected(accuracy.error());
  const auto final_accuracy = common::evaluate_trajectory((*slam)->final_trajectory(), part, se2);
  if (!final_accuracy) return tl::unexpected(final_accuracy.error());
  result.ate = accuracy->ate_rmse_m;
  result.final_ate = final_accuracy->ate_rmse_m;
  result.coverage = accuracy->coverage;
  result.milliseconds /= images;
  result.features /= images;
  result.refilled /= images;
  return result;
}

/// Mean and standard deviation of a number of each run.
std::pair<double, double> spread(const std::vector<Run>& runs, double Run::*number) {
  double mean = 0.0, squares = 0.0;
  for (const Run& one : runs) mean += one.*number / static_cast<double>(runs.size());
  for (const Run& one : runs) squares += (one.*number - mean) * (one.*number - mean);
  return {mean, runs.size() > 1 ? std::sqrt(squares / static_cast<double>(runs.size() - 1)) : 0.0};
}

/// The regions of an image, means over the recording's images.
struct Regions {
  double milliseconds = 0.0, objects = 0.0, share = 0.0;
};

Regions regions_of(const VisualMessages& recording, const visual_slam::FeatureSelection& selection) {
  constexpr int kEvery = 8;
  int images = 0, number = 0;
  Regions sum;
  for (const common::SensorMessage& message : recording.messages) {
    const auto* image = std::get_if<common::Image>(&message);
    if (image == nullptr || number++ % kEvery != 0) continue;
    const cv::Mat picture(image->height, image->width, CV_8UC1, const_cast<std::uint8_t*>(image->pixels->data()));
    const double start = processor_milliseconds();
    const visual_slam::SelectedRegion selected = selection.select(picture);
    sum.milliseconds += processor_milliseconds() - start;
    sum.objects += static_cast<double>(selected.objects.size());
    sum.share += selected.mask.empty()
                     ? 1.0
                     : static_cast<double>(cv::countNonZero(selected.mask)) / static_cast<double>(picture.total());
    ++images;
  }
  return {sum.milliseconds / images, sum.objects / images, sum.share / images};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) {
    return fail(
        "usage: benchmark_feature_selection RECORDING CAMERAS OBJECT_RECORDING RUNS SECONDS [visual.key=value ...]");
  }
  visual_slam::VisualSlamOptions options;
  for (int i = 6; i < argc; ++i) {
    const auto set = common::set_option(
        argv[i], [&](common::OptionVisitor& visit) { visit.nested("visual", options, "Visual SLAM."); });
    if (!set) return fail(set.error().message);
  }
  const auto recording = read_visual_messages(argv[1], argv[2]);
  if (!recording) return fail(recording.error().message);
  const auto truth = common::read_ground_truth(argv[1]);
  if (!truth) return fail(truth.error().message);
  CutOutFolder objects;
  {
    const auto other = read_visual_messages(argv[3], "cam0,cam1");
    if (!other) return fail(other.error().message);
    objects.fill(*other);
  }
  options.selection.objects = objects.path();
  const int runs = std::max(1, std::atoi(argv[4]));
  const double seconds = std::atof(argv[5]);
  const double duration = common::to_seconds(common::stamp_of(recording->messages.back()) - recording->first_stamp);

  std::printf(
      "strategy   error online (sd) [m]   final (sd) [m]   coverage   features   ms an image   "
      "without regions   regions: ms, objects, share\n");
  using visual_slam::SelectionStrategy;
  for (const auto& [name, strategy] :
       {std::pair{"none", SelectionStrategy::kNone}, std::pair{"bottom_up", SelectionStrategy::kBottomUp},
        std::pair{"top_down", SelectionStrategy::kTopDown}, std::pair{"both", SelectionStrategy::kBoth}}) {
    options.selection.strategy = strategy;
    const auto selection = visual_slam::FeatureSelection::create(options.selection);
    if (!selection) return fail(selection.error().message);
    std::vector<Run> all;
    for (int k = 0; k < runs; ++k) {
      const double from = runs > 1 ? k * std::max(0.0, duration - seconds) / (runs - 1) : 0.0;
      const auto one = run(*recording, *truth, options, from, from + seconds);
      if (!one) return fail(one.error().message);
      std::fprintf(stderr, "%s run %d: %.4f m, %.4f m, %.2f ms\n", name, k, one->ate, one->final_ate,
                   one->milliseconds);
      all.push_back(*one);
    }
    const auto [ate, ate_sd] = spread(all, &Run::ate);
    const auto [final_ate, final_sd] = spread(all, &Run::final_ate);
    const double milliseconds = spread(all, &Run::milliseconds).first;
    const Regions regions = regions_of(*recording, *selection);
    std::printf("%-10s %.4f (%.4f)   %.4f (%.4f)   %.4f   %.1f   %.2f   %.2f   %.2f %.2f %.2f\n", name, ate, ate_sd,
                final_ate, final_sd, spread(all, &Run::coverage).first, spread(all, &Run::features).first, milliseconds,
                milliseconds - spread(all, &Run::refilled).first * regions.milliseconds, regions.milliseconds,
                regions.objects, regions.share);
    std::fflush(stdout);
  }
  return EXIT_SUCCESS;
}
