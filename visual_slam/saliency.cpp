// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/saliency.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

namespace slamfuse::visual_slam {
namespace {

constexpr int kFirstLevel = 2;                  // the finest centre; pyramids start there
constexpr int kLastCentre = 4;                  // maps are added up at this level's size
constexpr std::array<int, 2> kSurrounds{3, 4};  // levels above the centre
constexpr int kLastLevel = kLastCentre + 4;
constexpr int kOrientations = 4;
constexpr int kGaborSize = 9;         // [px] of a level
constexpr double kGaborSigma = 2.0;   // [px]
constexpr double kGaborLength = 5.0;  // wavelength [px]
constexpr double kGaborAspect = 0.5;  // how much longer than wide
constexpr double kNoise = 2.0;        // differences of 8-bit values that mean nothing
constexpr int kPeakWidth = 3;         // cells around a local maximum
constexpr double kPeakLevel = 0.1;    // lower local maxima are not peaks
constexpr int kSmallestSide = 64;     // [px] of a picture

using Pyramid = std::vector<cv::Mat>;  // from kFirstLevel up

Pyramid make_pyramid(cv::Mat finest) {
  Pyramid levels{std::move(finest)};
  for (int level = kFirstLevel + 1; level <= kLastLevel; ++level) {
    cv::Mat next;
    cv::pyrDown(levels.back(), next);
    levels.push_back(next);
  }
  return levels;
}

/// Brings a map to 0..1 and weakens it the more peaks it has beside the highest: N(.) of Itti et al. A map that is
/// nowhere above `noise` becomes 0.
void promote_lone_peaks(cv::Mat& map, double noise) {
  double highest = 0.0;
  cv::minMaxLoc(map, nullptr, &highest);
  if (highest <= noise) {
    map.setTo(0.0);
    return;
  }
  map /= highest;
  cv::Mat peaks;
  cv::dilate(map, peaks, cv::getStructuringElement(cv::MORPH_RECT, {kPeakWidth, kPeakWidth}));
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < map.rows; ++y) {
    for (int x = 0; x < map.cols; ++x) {
      const double value = static_cast<double>(map.at<float>(y, x));
      if (map.at<float>(y, x) != peaks.at<float>(y, x) || value < kPeakLevel || value >= 1.0) continue;
      sum += value;
      ++count;
    }
  }
  const double mean = count > 0 ? sum / count : 0.0;
  map *= (1.0 - mean) * (1.0 - mean);
}

/// Adds up how centres differ from surrounds, at the size of level kLastCentre.
cv::Mat centre_surround(const Pyramid& levels) {
  const cv::Size size = levels[kLastCentre - kFirstLevel].size();
  cv::Mat sum = cv::Mat::zeros(size, CV_32F);
  for (int centre = kFirstLevel; centre <= kLastCentre; ++centre) {
    const cv::Mat& fine = levels[static_cast<std::size_t>(centre - kFirstLevel)];
    for (const int step : kSurrounds) {
      cv::Mat surround, difference, map;
      cv::resize(levels[static_cast<std::size_t>(centre + step - kFirstLevel)], surround, fine.size());
      cv::absdiff(fine, surround, difference);
      cv::resize(difference, map, size, 0.0, 0.0, cv::INTER_AREA);
      promote_lone_peaks(map, kNoise);
      sum += map;
    }
  }
  return sum;
}

/// How strongly each place of each level has edges in a direction.
Pyramid orientation_pyramid(const Pyramid& lightness, double angle) {
  cv::Mat kernel =
      cv::getGaborKernel({kGaborSize, kGaborSize}, kGaborSigma, angle, kGaborLength, kGaborAspect, 0.0, CV_32F);
  kernel -= cv::mean(kernel)[0];
  kernel /= cv::norm(kernel, cv::NORM_L1) / 2.0;
  Pyramid levels;
  for (const cv::Mat& level : lightness) {
    cv::Mat response;
    cv::filter2D(level, response, CV_32F, kernel, {-1, -1}, 0.0, cv::BORDER_REPLICATE);
    levels.push_back(cv::abs(response));
  }
  return levels;
}

cv::Mat orientation_maps(const Pyramid& lightness) {
  std::array<cv::Mat, kOrientations> maps;
  cv::parallel_for_({0, kOrientations}, [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      maps[static_cast<std::size_t>(i)] =
          centre_surround(orientation_pyramid(lightness, i * std::numbers::pi / kOrientations));
      promote_lone_peaks(maps[static_cast<std::size_t>(i)], 0.0);
    }
  });
  cv::Mat sum = maps[0];
  for (std::size_t i = 1; i < maps.size(); ++i) sum += maps[i];
  return sum;
}

/// The channels of CIE L*a*b* at the first level, 0..255 each; of gray only the lightness.
std::vector<cv::Mat> channels_of(const cv::Mat& picture) {
  cv::Mat small = picture;
  for (int level = 0; level < kFirstLevel; ++level) {
    cv::Mat next;
    cv::pyrDown(small, next);
    small = next;
  }
  const bool gray = small.channels() == 1;
  if (gray) cv::cvtColor(small, small, cv::COLOR_GRAY2BGR);
  cv::cvtColor(small, small, cv::COLOR_BGR2Lab);
  small.convertTo(small, CV_32F);
  std::vector<cv::Mat> channels;
  cv::split(small, channels);
  if (gray) channels.resize(1);
  return channels;
}

}  // namespace

cv::Mat saliency_map(const cv::Mat& picture) {
  if (std::min(picture.cols, picture.rows) < kSmallestSide) return cv::Mat::zeros(1, 1, CV_32F);
  const std::vector<cv::Mat> channels = channels_of(picture);
  const Pyramid lightness = make_pyramid(channels[0]);
  std::vector<cv::Mat> kinds{centre_surround(lightness), orientation_maps(lightness)};
  if (channels.size() == 3) {
    kinds.push_back(centre_surround(make_pyramid(channels[1])) + centre_surround(make_pyramid(channels[2])));
  }
  cv::Mat sum = cv::Mat::zeros(kinds[0].size(), CV_32F);
  for (cv::Mat& kind : kinds) {
    promote_lone_peaks(kind, 0.0);
    sum += kind;
  }
  return sum / static_cast<double>(kinds.size());
}

cv::Mat salient_region(const cv::Mat& picture, double share) {
  const cv::Mat map = saliency_map(picture);
  std::vector<float> values(map.begin<float>(), map.end<float>());
  const std::size_t kept = static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size())));
  if (kept == 0) return cv::Mat::zeros(picture.size(), CV_8UC1);
  const auto least = values.begin() + static_cast<std::ptrdiff_t>(std::min(kept, values.size()) - 1);
  std::nth_element(values.begin(), least, values.end(), std::greater<>());
  cv::Mat full;
  cv::resize(map, full, picture.size());
  return (full >= static_cast<double>(*least)) & (full > 0.0);
}

}  // namespace slamfuse::visual_slam
