// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/feature_selection.hpp"

#include <utility>

#include <opencv2/imgproc.hpp>

#include "visual_slam/saliency.hpp"

namespace slamfuse::visual_slam {
namespace {

bool uses_saliency(SelectionStrategy strategy) {
  return strategy == SelectionStrategy::kBottomUp || strategy == SelectionStrategy::kBoth;
}

bool uses_objects(SelectionStrategy strategy) {
  return strategy == SelectionStrategy::kTopDown || strategy == SelectionStrategy::kBoth;
}

}  // namespace

std::string SelectedRegion::object_at(const Eigen::Vector2d& pixel) const {
  const cv::Point2f point(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  for (const FoundObject& object : objects) {
    const std::vector<cv::Point2f> outline(object.outline.begin(), object.outline.end());
    if (cv::pointPolygonTest(outline, point, false) >= 0.0) return object.name;
  }
  return {};
}

common::Result<FeatureSelection> FeatureSelection::create(const SelectionOptions& options) {
  if (!uses_objects(options.strategy)) return FeatureSelection(options, std::nullopt);
  if (options.objects.empty()) {
    return common::invalid_input(
        "visual.selection.objects is empty; the strategies top_down and both need a folder of pictures of objects");
  }
  common::Result<ObjectDatabase> objects = ObjectDatabase::load(options.objects, options);
  if (!objects) return tl::unexpected(objects.error());
  return FeatureSelection(options, std::move(*objects));
}

SelectedRegion FeatureSelection::select(const cv::Mat& picture) const {
  SelectedRegion selected;
  if (options_.strategy == SelectionStrategy::kNone) return selected;
  selected.mask = uses_saliency(options_.strategy) ? salient_region(picture, options_.salient_share)
                                                   : cv::Mat(cv::Mat::zeros(picture.size(), CV_8UC1));
  if (!objects_) return selected;
  cv::Mat gray = picture;
  if (picture.channels() == 3) cv::cvtColor(picture, gray, cv::COLOR_BGR2GRAY);
  selected.objects = objects_->find(gray);
  for (const FoundObject& object : selected.objects) {
    const std::vector<cv::Point> outline(object.outline.begin(), object.outline.end());
    cv::fillConvexPoly(selected.mask, outline, cv::Scalar(255));
  }
  return selected;
}

}  // namespace slamfuse::visual_slam
