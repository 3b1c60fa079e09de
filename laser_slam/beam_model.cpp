// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/beam_model.hpp"

#include <algorithm>
#include <cmath>

#include "laser_slam/scan_explanation.hpp"

namespace slamfuse::laser_slam {

BeamModel::BeamModel(const LikelihoodField& field, const BeamModelOptions& options, double slack)
    : field_(&field),
      wall_in_the_way_(std::log(options.short_likelihood / (1.0 + options.short_likelihood))),
      nothing_(std::log(options.random_likelihood / (1.0 + options.random_likelihood))) {
  for (std::size_t i = 0; i < table_.size(); ++i) {
    const auto code = static_cast<LikelihoodField::Code>(i);
    const double distance = std::max(0.0, field.distance_of(code) - slack) / options.hit_sigma;
    const bool known = (code & LikelihoodField::kUnknown) == 0;
    const double floor = known ? options.short_likelihood : options.random_likelihood;
    table_[i] = static_cast<float>(std::log((std::exp(-0.5 * distance * distance) + floor) / (1.0 + floor)));
  }
}

double BeamModel::log_likelihood(const std::vector<Eigen::Vector2d>& points, const common::Pose2& pose) const {
  // In cells: one multiplication and one truncation a coordinate. Codes outside are far, so rounding towards zero at
  // the border does no harm.
  const double scale = 1.0 / field_->resolution();
  const double cosine = std::cos(pose.theta) * scale;
  const double sine = std::sin(pose.theta) * scale;
  const double x = (pose.x - field_->origin().x()) * scale;
  const double y = (pose.y - field_->origin().y()) * scale;
  double sum = 0.0;
  for (const Eigen::Vector2d& point : points) {
    const auto column = static_cast<int>(x + cosine * point.x() - sine * point.y());
    const auto row = static_cast<int>(y + sine * point.x() + cosine * point.y());
    sum += static_cast<double>(table_[field_->code(column, row)]);
  }
  return sum;
}

double BeamModel::traced_log_likelihood(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& mount,
                                        const common::Pose2& pose) const {
  const Eigen::Vector2d laser = pose * mount;
  double sum = 0.0;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d end = pose * point;
    const auto at_end = static_cast<double>(table_[field_->code_at(end)]);
    if (!passes_wall(*field_, laser, end)) {
      sum += at_end;
    } else {
      sum += std::min(at_end, std::max(at_end + wall_in_the_way_, nothing_));
    }
  }
  return sum;
}

}  // namespace slamfuse::laser_slam
