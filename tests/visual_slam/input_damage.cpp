// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/input_damage.hpp"

#include <memory>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace slamfuse::visual_slam::testing {
namespace {

constexpr double kSlip = 1.2;
constexpr double kFocalError = 1.1;
constexpr double kBlurSigma = 8.0;  // [px]
constexpr double kGain = 4.0;
constexpr double kOffset = 60.0;  // [gray]
constexpr double kCoveredGray = 12.0;
constexpr double kCoveredNoise = 3.0;

cv::Mat as_matrix(const common::Image& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels->data())};
}

common::Image with_pixels(common::Image image, const cv::Mat& picture) {
  image.width = picture.cols;
  image.height = picture.rows;
  image.pixels =
      std::make_shared<const std::vector<std::uint8_t>>(picture.begin<std::uint8_t>(), picture.end<std::uint8_t>());
  return image;
}

cv::Mat covered(const common::Image& image, unsigned picture) {
  cv::Mat noise(image.height, image.width, CV_32FC1);
  cv::RNG random(picture + 1);
  random.fill(noise, cv::RNG::NORMAL, kCoveredGray, kCoveredNoise);
  cv::Mat result;
  noise.convertTo(result, CV_8U);
  return result;
}

}  // namespace

std::string to_string(Damage damage) {
  switch (damage) {
    case Damage::kNone:
      return "none";
    case Damage::kBlack:
      return "black";
    case Damage::kWhite:
      return "white";
    case Damage::kOverExposed:
      return "over-exposed";
    case Damage::kBlurred:
      return "blurred";
    case Damage::kCovered:
      return "covered";
    case Damage::kFrozen:
      return "frozen";
    case Damage::kDropped:
      return "dropped";
    case Damage::kOutOfOrder:
      return "out of order";
    case Damage::kWrongSize:
      return "wrong size";
    case Damage::kWheelSlip:
      return "wheel slip";
    case Damage::kWrongIntrinsics:
      break;
  }
  return "wrong intrinsics";
}

std::vector<common::SensorMessage> Damager::apply(const common::SensorMessage& message) {
  if (const auto* odometry = std::get_if<common::WheelOdometry>(&message)) {
    return {damage_ == Damage::kWheelSlip ? slipped(*odometry) : *odometry};
  }
  const auto* image = std::get_if<common::Image>(&message);
  if (image == nullptr || image->stamp < from_ || image->stamp >= to_) {
    if (image != nullptr) last_[image->sensor] = *image;
    return {message};
  }
  return damaged(*image);
}

std::vector<common::SensorMessage> Damager::damaged(const common::Image& image) {
  cv::Mat picture;
  switch (damage_) {
    case Damage::kBlack:
      return {with_pixels(image, cv::Mat::zeros(image.height, image.width, CV_8UC1))};
    case Damage::kWhite:
      return {with_pixels(image, cv::Mat(image.height, image.width, CV_8UC1, cv::Scalar(255)))};
    case Damage::kOverExposed:
      as_matrix(image).convertTo(picture, CV_8U, kGain, kOffset);
      return {with_pixels(image, picture)};
    case Damage::kBlurred:
      cv::GaussianBlur(as_matrix(image), picture, {}, kBlurSigma);
      return {with_pixels(image, picture)};
    case Damage::kCovered:
      return {with_pixels(image, covered(image, pictures_++))};
    case Damage::kFrozen: {
      common::Image again = image;
      if (last_.contains(image.sensor)) again.pixels = last_[image.sensor].pixels;
      return {again};
    }
    case Damage::kDropped:
      return {};
    case Damage::kOutOfOrder: {
      const auto held = held_.find(image.sensor);
      if (held == held_.end()) {
        held_.emplace(image.sensor, image);
        return {};
      }
      std::vector<common::SensorMessage> both{image, held->second};
      held_.erase(held);
      return both;
    }
    case Damage::kWrongSize:
      cv::resize(as_matrix(image), picture, {}, 0.5, 0.5, cv::INTER_AREA);
      return {with_pixels(image, picture)};
    case Damage::kNone:
    case Damage::kWheelSlip:
    case Damage::kWrongIntrinsics:
      break;
  }
  return {image};
}

common::WheelOdometry Damager::slipped(const common::WheelOdometry& odometry) {
  if (!true_odometry_) slipped_odometry_ = odometry.pose;
  const common::Pose2 step = true_odometry_.value_or(odometry.pose).inverse() * odometry.pose;
  true_odometry_ = odometry.pose;
  const bool slips = odometry.stamp >= from_ && odometry.stamp < to_;
  slipped_odometry_ = slipped_odometry_ * (slips ? common::exp_se2(kSlip * common::log_se2(step)) : step);
  common::WheelOdometry result = odometry;
  result.pose = slipped_odometry_;
  if (slips) {
    result.forward_speed *= kSlip;
    result.turn_rate *= kSlip;
  }
  return result;
}

std::map<std::string, common::CameraCalibration> damaged(Damage damage,
                                                         std::map<std::string, common::CameraCalibration> cameras) {
  if (damage != Damage::kWrongIntrinsics) return cameras;
  for (auto& [name, camera] : cameras) {
    camera.fx *= kFocalError;
    camera.fy *= kFocalError;
  }
  return cameras;
}

}  // namespace slamfuse::visual_slam::testing
