// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/state.hpp"

#include <algorithm>
#include <cassert>

#include "visual_slam/body_pose.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr int kTile = 64;     // columns updated while they stay in the cache
constexpr int kGrowth = 256;  // rows allocated at a time
constexpr BlockId kRobot = 0;
constexpr BlockId kCalibration = 1;
constexpr int kHeadingIndex = 2;  // in a planar robot's block
constexpr int kTurnIndex = 3;     // in a free robot's block, the first of three

Eigen::Quaterniond rotation_in(const Eigen::VectorXd& mean, int mean_offset) {
  return Eigen::Quaterniond(mean.segment<4>(mean_offset + 3));
}

}  // namespace

void State::reserve(int size) {
  if (size <= covariance_.rows()) return;
  const int capacity = (size / kGrowth + 1) * kGrowth;
  Eigen::MatrixXd grown = Eigen::MatrixXd::Zero(capacity, capacity);
  grown.topLeftCorner(size_, size_) = covariance();
  covariance_.swap(grown);
}

Eigen::MatrixXd State::combine_rows(std::span<const JacobianPart<Eigen::Dynamic>> parts, int rows) const {
  Eigen::MatrixXd combined = Eigen::MatrixXd::Zero(size_, rows);
  for (const auto& part : parts) {
    combined.noalias() += covariance_.block(0, offset(part.block), size_, part.matrix.cols()) * part.matrix.transpose();
  }
  return combined;
}

BlockId State::append(const Eigen::VectorXd& mean, BlockKind kind, std::span<const JacobianPart<Eigen::Dynamic>> parts,
                      const Eigen::MatrixXd& noise) {
  const int rows = static_cast<int>(noise.rows());
  const int old_size = size_;
  const Eigen::MatrixXd cross = combine_rows(parts, rows);
  Eigen::MatrixXd self = noise;
  for (const auto& part : parts) self += part.matrix * cross.middleRows(offset(part.block), part.matrix.cols());
  reserve(old_size + rows);
  blocks_.push_back({old_size, rows, static_cast<int>(mean_.size()), kind});
  assert(mean.size() == blocks_.back().mean_size());
  alive_.push_back(blocks_.size() - 1);
  size_ = old_size + rows;
  mean_.conservativeResize(mean_.size() + mean.size());
  mean_.tail(mean.size()) = mean;
  covariance_.block(0, old_size, old_size, rows) = cross;
  covariance_.block(old_size, 0, rows, old_size) = cross.transpose();
  covariance_.block(old_size, old_size, rows, rows) = 0.5 * (self + self.transpose());
  return blocks_.size() - 1;
}

void State::transform(BlockId block, const Eigen::VectorXd& mean, BlockKind kind,
                      std::span<const JacobianPart<Eigen::Dynamic>> parts, const Eigen::MatrixXd& noise) {
  const int rows = static_cast<int>(noise.rows());
  assert(rows == blocks_[block].size);
  const Eigen::MatrixXd cross = combine_rows(parts, rows);
  Eigen::MatrixXd self = noise;
  for (const auto& part : parts) self += part.matrix * cross.middleRows(offset(part.block), part.matrix.cols());
  const int start = offset(block);
  blocks_[block].kind = kind;
  this->mean(block) = mean;
  covariance_.block(0, start, size_, rows) = cross;
  covariance_.block(start, 0, rows, size_) = cross.transpose();
  covariance_.block(start, start, rows, rows) = 0.5 * (self + self.transpose());
}

void State::remove(std::span<const BlockId> blocks) {
  if (blocks.empty()) return;
  for (const BlockId block : blocks) blocks_[block].offset = -1;
  std::erase_if(alive_, [this](BlockId block) { return blocks_[block].offset < 0; });
  std::vector<int> kept;
  kept.reserve(static_cast<std::size_t>(size_));
  int new_mean_size = 0;
  for (const BlockId id : alive_) {
    Block& block = blocks_[id];
    const int new_offset = static_cast<int>(kept.size());
    for (int i = 0; i < block.size; ++i) kept.push_back(block.offset + i);
    for (int i = 0; i < block.mean_size(); ++i) mean_[new_mean_size + i] = mean_[block.mean_offset + i];
    block.offset = new_offset;
    block.mean_offset = new_mean_size;
    new_mean_size += block.mean_size();
  }
  // New places lie before old ones, so moving column by column and row by row within a column overwrites nothing
  // needed.
  const int new_size = static_cast<int>(kept.size());
  for (int column = 0; column < new_size; ++column) {
    const double* from = covariance_.col(kept[static_cast<std::size_t>(column)]).data();
    double* to = covariance_.col(column).data();
    for (int row = 0; row < new_size; ++row) to[row] = from[kept[static_cast<std::size_t>(row)]];
  }
  size_ = new_size;
  mean_.conservativeResize(new_mean_size);
}

Eigen::MatrixXd State::covariance_times_jacobian(std::span<const LinearMeasurement> measurements) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(size_, 2 * static_cast<int>(measurements.size()));
  for (int i = 0; i < static_cast<int>(measurements.size()); ++i) {
    for (const auto& part : measurements[static_cast<std::size_t>(i)].jacobian) {
      product.middleCols<2>(2 * i).noalias() +=
          covariance_.block(0, offset(part.block), size_, part.matrix.cols()) * part.matrix.transpose();
    }
  }
  return product;
}

Eigen::MatrixXd State::jacobian_times(std::span<const LinearMeasurement> measurements, const Eigen::MatrixXd& m) const {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(2 * static_cast<int>(measurements.size()), m.cols());
  for (int i = 0; i < static_cast<int>(measurements.size()); ++i) {
    for (const auto& part : measurements[static_cast<std::size_t>(i)].jacobian) {
      product.middleRows<2>(2 * i).noalias() += part.matrix * m.middleRows(offset(part.block), part.matrix.cols());
    }
  }
  return product;
}

void State::retract(const Eigen::VectorXd& delta) {
  for (const BlockId id : alive_) {
    const Block& block = blocks_[id];
    const auto step = delta.segment(block.offset, block.size);
    if (block.kind == BlockKind::kFreePose) {
      const Eigen::Quaterniond turned = rotation_exp(step.tail<3>()) * rotation_in(mean_, block.mean_offset);
      mean_.segment<3>(block.mean_offset) += step.head<3>();
      mean_.segment<4>(block.mean_offset + 3) = turned.normalized().coeffs();
    } else {
      mean_.segment(block.mean_offset, block.size) += step;
    }
  }
}

Eigen::VectorXd State::error_given(const Eigen::VectorXd& mean) const {
  Eigen::VectorXd error(size_);
  for (const BlockId id : alive_) {
    const Block& block = blocks_[id];
    const int vector_size = block.kind == BlockKind::kFreePose ? 3 : block.size;
    error.segment(block.offset, vector_size) =
        mean.segment(block.mean_offset, vector_size) - mean_.segment(block.mean_offset, vector_size);
    if (block.kind == BlockKind::kFreePose) {
      error.segment<3>(block.offset + 3) =
          rotation_log(rotation_in(mean, block.mean_offset) * rotation_in(mean_, block.mean_offset).conjugate());
    }
  }
  return error;
}

void State::correct(const Eigen::VectorXd& delta) {
  const bool planar = blocks_[kRobot].kind == BlockKind::kPose;
  const int scale = blocks_[kCalibration].offset;
  retract(delta);
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(size_, 3);  // by an error of the robot's turn about x, y, z
  Eigen::VectorXd grown = Eigen::VectorXd::Zero(size_);      // by an error of the scale
  for (const BlockId id : alive_) {
    const Block& block = blocks_[id];
    const auto step = delta.segment(block.offset, block.size);
    switch (block.kind) {
      case BlockKind::kPose:
        turned.block<2, 1>(block.offset, 2) << -step[1], step[0];
        grown.segment<2>(block.offset) = step.head<2>();
        break;
      case BlockKind::kPoint:
      case BlockKind::kFreePose:
        turned.middleRows<3>(block.offset) = -cross_matrix(step.head<3>());
        grown.segment<3>(block.offset) = step.head<3>();
        break;
      case BlockKind::kInverseDepth:
        grown[block.offset + 2] = -step[2];
        break;
      case BlockKind::kVelocity:
        grown[block.offset + 1] = step[1];
        break;
      case BlockKind::kFreeVelocity:
        grown.segment<3>(block.offset + 1) = step.segment<3>(1);
        break;
      case BlockKind::kCalibration:
        break;
    }
  }
  const double old_scale = 1.0 + mean(kCalibration)[0] - delta[scale];
  grown /= old_scale;
  grown[scale] = delta[scale] / old_scale;
  const int robot = blocks_[kRobot].offset;
  std::vector<Dependence> dependences;
  if (planar) {
    dependences.push_back({robot + kHeadingIndex, turned.col(2)});
  } else {
    for (int axis = 0; axis < 3; ++axis) dependences.push_back({robot + kTurnIndex + axis, turned.col(axis)});
  }
  dependences.push_back({scale, std::move(grown)});
  add(dependences);
}

/// P <- (I + c e^T) P (I + c e^T)^T for one dependence after the other, e being the unit vector of its index: the error
/// there is added, times c, to the others.
void State::add(std::span<const Dependence> dependences) {
  // Each is P + c w^T + w c^T with w = P e + s/2 c and s = e^T P e; all w first, so that P is passed through once.
  std::vector<Eigen::VectorXd> all_w;
  for (const auto& [index, c] : dependences) {
    Eigen::VectorXd w = covariance_.col(index).head(size_);
    for (std::size_t i = 0; i < all_w.size(); ++i) {
      const Eigen::VectorXd& before = dependences[i].c;
      w += before * all_w[i][index] + all_w[i] * before[index];
    }
    w += 0.5 * w[index] * c;
    all_w.push_back(std::move(w));
  }
  for (int column = 0; column < size_; ++column) {
    for (std::size_t i = 0; i < all_w.size(); ++i) {
      const Eigen::VectorXd& c = dependences[i].c;
      covariance_.col(column).head(size_) += c * all_w[i][column] + all_w[i] * c[column];
    }
  }
}

void State::correct_alone(BlockId block, double residual, std::span<const JacobianPart<1>> jacobian, double variance) {
  Eigen::VectorXd cross = Eigen::VectorXd::Zero(size_);  // P h
  for (const auto& part : jacobian) {
    cross.noalias() += covariance_.block(0, offset(part.block), size_, part.matrix.cols()) * part.matrix.transpose();
  }
  double innovation = variance;
  for (const auto& part : jacobian) {
    innovation += part.matrix.row(0).dot(cross.segment(offset(part.block), part.matrix.cols()));
  }
  const int start = offset(block);
  const int rows = blocks_[block].size;
  const Eigen::VectorXd gain = cross.segment(start, rows) / innovation;
  mean(block) += gain * residual;
  covariance_.block(0, start, size_, rows).noalias() -= cross * gain.transpose();
  covariance_.block(start, 0, rows, size_) = covariance_.block(0, start, size_, rows).transpose();
  if (blocks_[block].kind == BlockKind::kInverseDepth) {
    // As in correct(), with only one number that moved.
    const int depth = start + 2;
    const int scale = blocks_[kCalibration].offset;
    const double moved = -gain[2] * residual / (1.0 + mean(kCalibration)[0]);
    covariance_.col(depth).head(size_) += moved * covariance_.col(scale).head(size_);
    covariance_.row(depth).head(size_) += moved * covariance_.row(scale).head(size_);
  }
}

void State::subtract_outer_product(const Eigen::MatrixXd& y) {
  for (int start = 0; start < size_; start += kTile) {
    const int width = std::min(kTile, size_ - start);
    const int below = size_ - start - width;
    covariance_.block(start, start, size_ - start, width).noalias() -=
        y.middleRows(start, size_ - start) * y.middleRows(start, width).transpose();
    covariance_.block(start, start + width, width, below) =
        covariance_.block(start + width, start, below, width).transpose();
  }
}

}  // namespace slamfuse::visual_slam
