// SPDX-License-Identifier: BSD-3-Clause
#include "office.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/angle.hpp"

namespace slamfuse {
namespace {

using Eigen::Vector2d;

constexpr double kHalfCorridor = 1.2;
constexpr double kRoomWidth = 4.0;
constexpr double kRoomDepth = 5.0;
constexpr double kDoor = 1.0;
constexpr double kBucket = 2.0;
constexpr double kNoise = 0.01;
constexpr double kMargin = 10.0;  // of the buckets around the building

/// The i-th of n lines spread evenly over a length.
double line_at(int i, int n, double length) { return n > 1 ? length * i / (n - 1) : 0.0; }

/// The point at `along` a corridor and `across` it.
Vector2d point(bool along_x, double along, double across) {
  return along_x ? Vector2d(along, across) : Vector2d(across, along);
}

}  // namespace

Office::Office(const OfficePlan& plan)
    : plan_(plan),
      low_(-kMargin, -kMargin),
      bucket_columns_(static_cast<int>((plan.width + 2.0 * kMargin) / kBucket) + 1),
      bucket_rows_(static_cast<int>((plan.height + 2.0 * kMargin) / kBucket) + 1),
      buckets_(static_cast<std::size_t>(bucket_columns_) * static_cast<std::size_t>(bucket_rows_)) {
  laser_slam::RandomStream random(2024, 1);
  for (const bool along_x : {true, false}) {
    for (int corridor = 0; corridor < (along_x ? plan.rows : plan.columns); ++corridor) {
      for (const double side : {-1.0, 1.0}) add_side(along_x, corridor, side, random);
    }
  }
}

/// One wall of a corridor: open where others cross, with doors, the rooms behind them and furniture.
void Office::add_side(bool along_x, int corridor, double side, laser_slam::RandomStream& random) {
  const double length = along_x ? plan_.width : plan_.height;
  const double breadth = along_x ? plan_.height : plan_.width;
  const int crossings = along_x ? plan_.columns : plan_.rows;
  const double wall = line_at(corridor, along_x ? plan_.rows : plan_.columns, breadth) + side * kHalfCorridor;
  const bool outside = wall < 0.0 || wall > breadth;
  std::vector<std::pair<double, double>> gaps;
  for (int i = 0; i < crossings && !outside; ++i) {
    const double at = line_at(i, crossings, length);
    gaps.emplace_back(at - kHalfCorridor, at + kHalfCorridor);
  }
  for (int i = 0; i + 1 < crossings; ++i) {
    const double from = line_at(i, crossings, length) + kHalfCorridor + (outside ? 0.3 : kRoomDepth + 0.6);
    const double to = line_at(i + 1, crossings, length) - kHalfCorridor - (outside ? 0.3 : kRoomDepth + 0.6);
    for (double at = from; at + kRoomWidth + 0.4 < to; at += kRoomWidth + 0.3 + 3.0 * random.uniform()) {
      const double door = at + 0.4 + (kRoomWidth - kDoor - 0.8) * random.uniform();
      gaps.emplace_back(door, door + kDoor);
      const double back = wall + side * kRoomDepth;
      add_segment(point(along_x, at, wall), point(along_x, at, back));
      add_segment(point(along_x, at, back), point(along_x, at + kRoomWidth, back));
      add_segment(point(along_x, at + kRoomWidth, back), point(along_x, at + kRoomWidth, wall));
      const double desk = at + 0.2 + 1.5 * random.uniform();
      const double from_wall = side * (1.5 + 2.0 * random.uniform());
      add_box(point(along_x, desk, wall + from_wall), point(along_x, desk + 1.4, wall + from_wall + side * 0.7));
      if (random.uniform() < 0.4) {  // furniture in the corridor, beside the door
        const double cupboard = door + kDoor + 0.3;
        const double depth = side * (0.2 + 0.2 * random.uniform());
        add_box(point(along_x, cupboard, wall), point(along_x, cupboard + 0.5, wall - depth));
      }
    }
  }
  std::sort(gaps.begin(), gaps.end());
  double from = -kHalfCorridor;
  for (const auto& [begin, end] : gaps) {
    if (begin > from) add_segment(point(along_x, from, wall), point(along_x, begin, wall));
    from = std::max(from, end);
  }
  if (from < length + kHalfCorridor) {
    add_segment(point(along_x, from, wall), point(along_x, length + kHalfCorridor, wall));
  }
}

void Office::add_box(const Vector2d& corner, const Vector2d& opposite) {
  const Vector2d b(opposite.x(), corner.y());
  const Vector2d d(corner.x(), opposite.y());
  add_segment(corner, b);
  add_segment(b, opposite);
  add_segment(opposite, d);
  add_segment(d, corner);
}

void Office::add_segment(const Vector2d& from, const Vector2d& to) {
  const int index = static_cast<int>(segments_.size());
  segments_.emplace_back(from, to);
  const Vector2d first = (from.cwiseMin(to) - low_) / kBucket;
  const Vector2d last = (from.cwiseMax(to) - low_) / kBucket;
  for (int y = static_cast<int>(first.y()); y <= static_cast<int>(last.y()); ++y) {
    for (int x = static_cast<int>(first.x()); x <= static_cast<int>(last.x()); ++x) {
      buckets_[static_cast<std::size_t>(y) * static_cast<std::size_t>(bucket_columns_) + static_cast<std::size_t>(x)]
          .push_back(index);
    }
  }
}

const std::vector<int>* Office::bucket(int x, int y) const {
  if (x < 0 || y < 0 || x >= bucket_columns_ || y >= bucket_rows_) return nullptr;
  return &buckets_[static_cast<std::size_t>(y) * static_cast<std::size_t>(bucket_columns_) +
                   static_cast<std::size_t>(x)];
}

double Office::cast(const Vector2d& from, double bearing, double farthest) const {
  const Vector2d direction(std::cos(bearing), std::sin(bearing));
  const auto cross = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
  double nearest = farthest;
  // Half a square a step, each with its neighbours: none is missed.
  for (double at = 0.0; at <= nearest + kBucket; at += kBucket / 2.0) {
    const Vector2d here = (from + at * direction - low_) / kBucket;
    const int center_x = static_cast<int>(std::floor(here.x() - 0.5));
    const int center_y = static_cast<int>(std::floor(here.y() - 0.5));
    for (const auto& [x, y] : {std::pair(center_x, center_y), std::pair(center_x + 1, center_y),
                               std::pair(center_x, center_y + 1), std::pair(center_x + 1, center_y + 1)}) {
      const std::vector<int>* near = bucket(x, y);
      if (!near) continue;
      for (const int i : *near) {
        const auto& [a, b] = segments_[static_cast<std::size_t>(i)];
        const double facing = cross(direction, b - a);
        if (std::abs(facing) < 1e-12) continue;
        const double along = cross(a - from, b - a) / facing;
        const double share = cross(a - from, direction) / facing;
        if (along > 0.0 && share >= 0.0 && share <= 1.0) nearest = std::min(nearest, along);
      }
    }
  }
  return nearest;
}

std::vector<common::Pose2> Office::drive(double step) const {
  std::vector<Vector2d> stops{{0.0, 0.0}};
  for (int row = 0; row < plan_.rows; ++row) {
    stops.emplace_back(stops.back().x(), line_at(row, plan_.rows, plan_.height));
    stops.emplace_back(row % 2 == 0 ? plan_.width : 0.0, stops.back().y());
  }
  const bool from_left = stops.back().x() == 0.0;
  for (int i = 0; i < plan_.columns; ++i) {
    const int column = from_left ? i : plan_.columns - 1 - i;
    stops.emplace_back(line_at(column, plan_.columns, plan_.width), stops.back().y());
    stops.emplace_back(stops.back().x(), i % 2 == 0 ? 0.0 : plan_.height);
  }

  constexpr double kTurn = 0.3;
  std::vector<common::Pose2> poses{{0.0, 0.0, 0.0}};
  for (std::size_t i = 1; i < stops.size(); ++i) {
    const Vector2d way = stops[i] - stops[i - 1];
    if (way.norm() < step) continue;
    const double heading = std::atan2(way.y(), way.x());
    const double turn = common::angle_difference(heading, poses.back().theta);
    for (int k = static_cast<int>(std::ceil(std::abs(turn) / kTurn)) - 1; k >= 0; --k) {
      common::Pose2 pose = poses.back();
      pose.theta = common::normalize_angle(heading - std::copysign(k * kTurn, turn));
      poses.push_back(pose);
    }
    const int steps = static_cast<int>(std::lround(way.norm() / step));
    for (int k = 1; k <= steps; ++k) {
      const Vector2d at = stops[i - 1] + way * k / steps;
      poses.push_back({at.x(), at.y(), heading});
    }
  }
  return poses;
}

common::LaserCalibration office_laser(int beams) {
  const double view = beams < 300 ? common::to_radians(270.0) : 2.0 * std::numbers::pi * (beams - 1) / beams;
  common::LaserCalibration laser;
  laser.angle_min = -view / 2.0;
  laser.angle_increment = view / (beams - 1);
  laser.beams = beams;
  laser.range_min = 0.05;
  laser.range_max = 30.0;
  return laser;
}

common::LaserScan office_scan(const Office& office, const common::LaserCalibration& laser, common::Nanoseconds stamp,
                              const common::Pose2& pose, laser_slam::RandomStream& noise) {
  common::LaserScan scan;
  scan.stamp = stamp;
  scan.sensor = "laser0";
  scan.ranges.reserve(static_cast<std::size_t>(laser.beams));
  for (int i = 0; i < laser.beams; ++i) {
    const double bearing = pose.theta + laser.angle_min + i * laser.angle_increment;
    const double range = office.cast(pose.translation(), bearing, laser.range_max) + kNoise * noise.normal();
    scan.ranges.push_back(range < laser.range_max - 0.1 ? static_cast<float>(range) : HUGE_VALF);
  }
  return scan;
}

}  // namespace slamfuse
