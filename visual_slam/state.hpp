// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::visual_slam {

/// Names a block of the state as long as it lives; never used again afterwards.
using BlockId = std::size_t;

/// How a block behaves when the whole map turns; see State::correct.
enum class BlockFrame {
  kMap,    ///< its first two numbers are a position in the map
  kLocal,  ///< relative to another block or to nothing (inverse-depth parameters, calibration)
};

/// The most columns a Jacobian part may have: the 13 numbers of a free camera (seed 002 section 2.2).
inline constexpr int kMaxBlockSize = 13;

/// Part of a Jacobian: its columns for one block, the other columns being zero.
template <int Rows>
struct JacobianPart {
  BlockId block = 0;
  Eigen::Matrix<double, Rows, Eigen::Dynamic, 0, Rows, kMaxBlockSize> matrix;
};

/// A linearised measurement of two numbers: residual = z - h(x), rows of H by block, noise covariance sigma^2 I.
struct LinearMeasurement {
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  std::vector<JacobianPart<2>> jacobian;
  double sigma = 1.0;
};

/// Mean and dense covariance of everything the filter estimates, in blocks that come and go.
///
/// The first block is the robot; its third number is the heading that turns with the map.
class State {
 public:
  int size() const { return size_; }
  /// Where a block starts, -1 when it is gone.
  int offset(BlockId block) const { return blocks_[block].offset; }
  bool has(BlockId block) const { return block < blocks_.size() && blocks_[block].offset >= 0; }
  auto mean(BlockId block) const { return mean_.segment(blocks_[block].offset, blocks_[block].size); }
  auto mean(BlockId block) { return mean_.segment(blocks_[block].offset, blocks_[block].size); }
  const Eigen::VectorXd& mean() const { return mean_; }
  auto covariance() const { return covariance_.topLeftCorner(size_, size_); }
  auto covariance(BlockId row, BlockId column) const {
    return covariance_.block(offset(row), offset(column), blocks_[row].size, blocks_[column].size);
  }

  /// Adds a block whose error is sum_k J_k e_k + noise.
  BlockId append(const Eigen::VectorXd& mean, BlockFrame frame, std::span<const JacobianPart<Eigen::Dynamic>> parts,
                 const Eigen::MatrixXd& noise);
  /// Replaces a block by a function of blocks (maybe itself): its error becomes sum_k J_k e_k + noise.
  void transform(BlockId block, const Eigen::VectorXd& mean, BlockFrame frame,
                 std::span<const JacobianPart<Eigen::Dynamic>> parts, const Eigen::MatrixXd& noise);
  void remove(std::span<const BlockId> blocks);

  /// P H^T (size x 2m) of stacked measurements.
  Eigen::MatrixXd covariance_times_jacobian(std::span<const LinearMeasurement> measurements) const;
  /// H M (2m x columns of M) for the stacked H.
  Eigen::MatrixXd jacobian_times(std::span<const LinearMeasurement> measurements, const Eigen::MatrixXd& m) const;

  /// Moves the mean by `delta` and turns the covariance along with it.
  ///
  /// A plain EKF gains false certainty about the heading of the whole map, because the direction that no measurement
  /// sees (all positions turning about the origin) is evaluated at estimates that change. Moving the mean of a position
  /// by d adds J d times the heading error to its error (J: quarter turn), which keeps that direction unseen exactly;
  /// this is the right-invariant EKF written in ordinary coordinates (Barrau and Bonnabel 2015, not in the seeds).
  void correct(const Eigen::VectorXd& delta);
  /// P <- P - Y Y^T.
  void subtract_outer_product(const Eigen::MatrixXd& y);

 private:
  struct Block {
    int offset;
    int size;
    BlockFrame frame;
  };

  Eigen::MatrixXd combine_rows(std::span<const JacobianPart<Eigen::Dynamic>> parts, int rows) const;
  void reserve(int size);

  std::vector<Block> blocks_;   // by id
  std::vector<BlockId> alive_;  // in the order of their offsets
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;  // symmetric, at least size_ x size_
  int size_ = 0;
};

}  // namespace slamfuse::visual_slam
