// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/state.hpp"

#include <algorithm>
#include <cassert>

namespace slamfuse::visual_slam {
namespace {

constexpr int kTile = 64;     // columns updated while they stay in the cache
constexpr int kGrowth = 256;  // rows allocated at a time
constexpr BlockId kRobot = 0;
constexpr BlockId kCalibration = 1;
constexpr int kHeadingIndex = 2;  // in the robot's block

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
  const int rows = static_cast<int>(mean.size());
  const int old_size = size_;
  const Eigen::MatrixXd cross = combine_rows(parts, rows);
  Eigen::MatrixXd self = noise;
  for (const auto& part : parts) self += part.matrix * cross.middleRows(offset(part.block), part.matrix.cols());
  reserve(old_size + rows);
  blocks_.push_back({old_size, rows, kind});
  alive_.push_back(blocks_.size() - 1);
  size_ = old_size + rows;
  mean_.conservativeResize(size_);
  mean_.tail(rows) = mean;
  covariance_.block(0, old_size, old_size, rows) = cross;
  covariance_.block(old_size, 0, rows, old_size) = cross.transpose();
  covariance_.block(old_size, old_size, rows, rows) = 0.5 * (self + self.transpose());
  return blocks_.size() - 1;
}

void State::transform(BlockId block, const Eigen::VectorXd& mean, BlockKind kind,
                      std::span<const JacobianPart<Eigen::Dynamic>> parts, const Eigen::MatrixXd& noise) {
  const int rows = static_cast<int>(mean.size());
  assert(rows == blocks_[block].size);
  const Eigen::MatrixXd cross = combine_rows(parts, rows);
  Eigen::MatrixXd self = noise;
  for (const auto& part : parts) self += part.matrix * cross.middleRows(offset(part.block), part.matrix.cols());
  const int start = offset(block);
  blocks_[block].kind = kind;
  mean_.segment(start, rows) = mean;
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
  for (const BlockId id : alive_) {
    Block& block = blocks_[id];
    const int new_offset = static_cast<int>(kept.size());
    for (int i = 0; i < block.size; ++i) kept.push_back(block.offset + i);
    block.offset = new_offset;
  }
  // New places lie before old ones, so moving column by column and row by row within a column overwrites nothing
  // needed.
  const int new_size = static_cast<int>(kept.size());
  for (int column = 0; column < new_size; ++column) {
    const double* from = covariance_.col(kept[static_cast<std::size_t>(column)]).data();
    double* to = covariance_.col(column).data();
    for (int row = 0; row < new_size; ++row) to[row] = from[kept[static_cast<std::size_t>(row)]];
    mean_[column] = mean_[kept[static_cast<std::size_t>(column)]];
  }
  size_ = new_size;
  mean_.conservativeResize(size_);
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

void State::correct(const Eigen::VectorXd& delta) {
  mean_ += delta;
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(size_, 2);  // by an error of the heading, of the scale
  for (const BlockId id : alive_) {
    const Block& block = blocks_[id];
    const auto step = delta.segment(block.offset, block.size);
    if (block.kind == BlockKind::kPose || block.kind == BlockKind::kPoint) {
      moved.block<2, 1>(block.offset, 0) << -step[1], step[0];
      moved.block<2, 1>(block.offset, 1) = step.head<2>();
    }
    if (block.kind == BlockKind::kPoint) moved(block.offset + 2, 1) = step[2];
    if (block.kind == BlockKind::kInverseDepth) moved(block.offset + 2, 1) = -step[2];
    if (block.kind == BlockKind::kVelocity) moved(block.offset + 1, 1) = step[1];
  }
  const int heading = blocks_[kRobot].offset + kHeadingIndex;
  const int scale = blocks_[kCalibration].offset;
  const double old_scale = 1.0 + mean_[scale] - delta[scale];
  moved.col(1) /= old_scale;
  moved(scale, 1) = delta[scale] / old_scale;
  add_dependence(heading, moved.col(0));
  add_dependence(scale, moved.col(1));
}

/// P <- (I + c e^T) P (I + c e^T)^T for the unit vector e of one number: its error is added, times c, to the others.
void State::add_dependence(int index, const Eigen::VectorXd& c) {
  // = P + c (w + s/2 c)^T + (w + s/2 c) c^T with w = P e and s = e^T P e.
  const Eigen::VectorXd w = covariance_.col(index).head(size_) + 0.5 * covariance_(index, index) * c;
  for (int column = 0; column < size_; ++column) {
    covariance_.col(column).head(size_) += c * w[column] + w * c[column];
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
  mean_.segment(start, rows) += gain * residual;
  covariance_.block(0, start, size_, rows).noalias() -= cross * gain.transpose();
  covariance_.block(start, 0, rows, size_) = covariance_.block(0, start, size_, rows).transpose();
  if (blocks_[block].kind == BlockKind::kInverseDepth) {
    // As in correct(), with only one number that moved.
    const int depth = start + 2;
    const int scale = blocks_[kCalibration].offset;
    const double moved = -gain[2] * residual / (1.0 + mean_[scale]);
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
