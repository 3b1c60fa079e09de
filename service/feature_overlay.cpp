// SPDX-License-Identifier: BSD-3-Clause
#include "service/feature_overlay.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "service/grid_png.hpp"
#include "service/svg.hpp"

namespace slamfuse::service {
namespace {

using common::FeatureOutcome;

constexpr int kMaxWidth = 480;  // [px]
constexpr int kJpegQuality = 72;
constexpr double kRadius = 4.0;  // of a mark [user units]
constexpr double kLegendEntry = 128.0;

struct KindStyle {
  FeatureOutcome kind;
  const char* style;
  const char* label;
};
constexpr std::array<KindStyle, 4> kKinds{{{FeatureOutcome::kFollowed, "followed", "followed"},
                                           {FeatureOutcome::kRecognised, "recognised", "recognised"},
                                           {FeatureOutcome::kRejected, "rejected", "rejected"},
                                           {FeatureOutcome::kNew, "new", "new"}}};

/// A ring, a square, a cross and a plus.
std::string mark(FeatureOutcome kind, double x, double y) {
  constexpr double r = kRadius;
  switch (kind) {
    case FeatureOutcome::kFollowed:
      return fmt::format("M{:.1f} {:.1f}a{} {} 0 1 0 {} 0a{} {} 0 1 0 -{} 0", x - r, y, r, r, 2 * r, r, r, 2 * r);
    case FeatureOutcome::kRecognised:
      return fmt::format("M{:.1f} {:.1f}h{}v{}h-{}z", x - r, y - r, 2 * r, 2 * r, 2 * r);
    case FeatureOutcome::kRejected:
      return fmt::format("M{:.1f} {:.1f}l{} {}m0 -{}l-{} {}", x - r, y - r, 2 * r, 2 * r, 2 * r, 2 * r, 2 * r);
    case FeatureOutcome::kNew:
      break;
  }
  return fmt::format("M{:.1f} {:.1f}h{}m-{} -{}v{}", x - r, y, 2 * r, r, r, 2 * r);
}

/// The marks with a dark rim, so that they show on any ground.
std::string marks(const std::string& d, const char* style) {
  return d.empty() ? ""
                   : fmt::format("<path class=\"rim\" d=\"{0}\"/><path class=\"feature {1}\" d=\"{0}\"/>", d, style);
}

}  // namespace

std::string feature_overlay(const common::AnnotatedImage& annotated) {
  const common::Image& image = annotated.image;
  if (!image.pixels || image.width <= 0 || image.height <= 0) return "";
  const cv::Mat picture(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data()));
  const double scale = std::min(1.0, static_cast<double>(kMaxWidth) / image.width);
  cv::Mat small;
  cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", small, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  std::string svg = svg_start(small.cols, small.rows, "Image of " + image.sensor + " with its features") +
                    fmt::format("<image width=\"{}\" height=\"{}\" href=\"data:image/jpeg;base64,{}\"/>", small.cols,
                                small.rows, to_base64({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()}));
  for (const KindStyle& kind : kKinds) {
    std::string d;
    for (const common::FeatureMark& feature : annotated.features) {
      // Pixel centres are at whole numbers, those of the drawing at halves.
      const Eigen::Vector2d at = scale * (feature.pixel + Eigen::Vector2d(0.5, 0.5));
      if (feature.kind == kind.kind) d += mark(kind.kind, at.x(), at.y());
    }
    svg += marks(d, kind.style);
  }
  return svg + "</svg>";
}

std::string feature_legend() {
  std::string svg = svg_start(kLegendEntry * kKinds.size(), 24, "What the marks mean");
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    const double x = kLegendEntry * static_cast<double>(i);
    svg +=
        marks(mark(kKinds[i].kind, x + 8, 12), kKinds[i].style) + svg_text(x + 20, 16, kKinds[i].label, "start", "key");
  }
  return svg + "</svg>";
}

std::string features_in_words(const common::AnnotatedImage& image) {
  std::string words;
  for (const KindStyle& kind : kKinds) {
    const auto count = std::count_if(image.features.begin(), image.features.end(),
                                     [&](const common::FeatureMark& feature) { return feature.kind == kind.kind; });
    words += fmt::format("{}{} {}", words.empty() ? "" : ", ", count, kind.label);
  }
  return words + "; " + common::to_string(image.state);
}

}  // namespace slamfuse::service
