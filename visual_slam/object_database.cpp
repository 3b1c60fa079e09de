// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/object_database.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/image_decoder.hpp"

namespace slamfuse::visual_slam {
namespace {

namespace fs = std::filesystem;

constexpr int kFeaturesAnObject = 400;
constexpr int kFeaturesAPicture = 1000;
constexpr int kNeighbours = 4;
constexpr double kRansacDistance = 4.0;  // [px] of the picture
constexpr int kRansacRounds = 500;
constexpr double kSmallestArea = 200.0;  // [px^2]
constexpr double kLargestShare = 4.0;    // of the picture's area: an outline may well lie partly outside

/// The pictures in a folder, by name.
common::Result<std::vector<fs::path>> picture_files(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    for (const char* known : {".jpg", ".jpeg", ".png", ".pgm", ".ppm"}) {
      if (ending == known) files.push_back(entry.path());
    }
  }
  if (error) {
    return common::invalid_input(
        fmt::format("visual.selection.objects: folder '{}': {}", folder.string(), error.message()));
  }
  if (files.empty()) {
    return common::invalid_input(fmt::format(
        "visual.selection.objects: folder '{}' holds no picture (.jpg, .jpeg, .png, .pgm, .ppm)", folder.string()));
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) { return a.stem() < b.stem(); });
  const auto twice = std::adjacent_find(files.begin(), files.end(),
                                        [](const fs::path& a, const fs::path& b) { return a.stem() == b.stem(); });
  if (twice != files.end()) {
    return common::invalid_input(
        fmt::format("{} and {}: two objects of one name", twice->string(), std::next(twice)->string()));
  }
  return files;
}

}  // namespace

bool is_plausible_outline(const std::array<cv::Point2f, 4>& outline, const cv::Size& picture) {
  for (std::size_t i = 0; i < 4; ++i) {
    const cv::Point2f side = outline[(i + 1) % 4] - outline[i];
    const cv::Point2f next = outline[(i + 2) % 4] - outline[(i + 1) % 4];
    if (!(side.cross(next) > 0.0F)) return false;  // also what is not a number
  }
  const double area = cv::contourArea(std::vector<cv::Point2f>(outline.begin(), outline.end()));
  return area >= kSmallestArea && area <= kLargestShare * picture.area();
}

ObjectDatabase::ObjectDatabase(const SelectionOptions& options, std::vector<Object> objects,
                               std::vector<cv::KeyPoint> keypoints, std::vector<std::size_t> owners,
                               const cv::Mat& descriptors)
    : options_(options),
      extractor_(options.object_features, kFeaturesAPicture),
      objects_(std::move(objects)),
      keypoints_(std::move(keypoints)),
      owners_(std::move(owners)),
      index_(options.object_features, DescriptorSearch::kFlann, descriptors) {}

common::Result<ObjectDatabase> ObjectDatabase::load(const fs::path& folder, const SelectionOptions& options) {
  const common::Result<std::vector<fs::path>> files = picture_files(folder);
  if (!files) return tl::unexpected(files.error());
  const FeatureExtractor extractor(options.object_features, kFeaturesAnObject);
  std::vector<Object> objects;
  std::vector<cv::KeyPoint> keypoints;
  std::vector<std::size_t> owners;
  cv::Mat descriptors;
  for (const fs::path& file : *files) {
    const common::Result<common::GrayImage> image = common::read_gray_image(file, std::nullopt);
    if (!image) return tl::unexpected(image.error());
    const cv::Mat picture(image->size.height, image->size.width, CV_8UC1,
                          const_cast<std::uint8_t*>(image->pixels->data()));
    const Features features = extractor.extract(picture);
    if (static_cast<int>(features.keypoints.size()) < options.object_matches) {
      return common::invalid_input(
          fmt::format("{}: {} features in a picture of {} x {} px, visual.selection.object_matches wants at least {}",
                      file.string(), features.keypoints.size(), picture.cols, picture.rows, options.object_matches));
    }
    keypoints.insert(keypoints.end(), features.keypoints.begin(), features.keypoints.end());
    owners.insert(owners.end(), features.keypoints.size(), objects.size());
    descriptors.push_back(features.descriptors);
    objects.push_back({file.stem().string(), picture.size()});
  }
  return ObjectDatabase(options, std::move(objects), std::move(keypoints), std::move(owners), descriptors);
}

std::vector<FoundObject> ObjectDatabase::find(const cv::Mat& picture) const {
  const Features features = extractor_.extract(picture);
  const auto neighbours = index_.nearest(features.descriptors, kNeighbours, cv::Mat());
  struct Pairs {
    std::vector<cv::Point2f> object, picture;
  };
  std::vector<Pairs> pairs(objects_.size());
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    const std::optional<Neighbour> match =
        clear_match(options_.object_features, options_.object_match_ratio, neighbours[i], keypoints_);
    if (!match) continue;
    const std::size_t feature = static_cast<std::size_t>(match->index);
    pairs[owners_[feature]].object.push_back(keypoints_[feature].pt);
    pairs[owners_[feature]].picture.push_back(features.keypoints[i].pt);
  }
  std::vector<FoundObject> found;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (static_cast<int>(pairs[i].object.size()) < options_.object_matches) continue;
    cv::Mat inliers;
    const cv::Mat homography =
        cv::findHomography(pairs[i].object, pairs[i].picture, cv::RANSAC, kRansacDistance, inliers, kRansacRounds);
    if (homography.empty() || cv::countNonZero(inliers) < options_.object_matches) continue;
    const float width = static_cast<float>(objects_[i].size.width),
                height = static_cast<float>(objects_[i].size.height);
    const std::vector<cv::Point2f> corners{{0.0F, 0.0F}, {width, 0.0F}, {width, height}, {0.0F, height}};
    std::vector<cv::Point2f> outline;
    cv::perspectiveTransform(corners, outline, homography);
    FoundObject object{objects_[i].name, {outline[0], outline[1], outline[2], outline[3]}};
    if (is_plausible_outline(object.outline, picture.size())) found.push_back(std::move(object));
  }
  return found;
}

std::vector<std::string> ObjectDatabase::names() const {
  std::vector<std::string> names;
  for (const Object& object : objects_) names.push_back(object.name);
  return names;
}

}  // namespace slamfuse::visual_slam
