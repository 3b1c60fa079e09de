// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace slamfuse::visual_slam {

/// Names a block of the state as long as it lives; never used again afterwards.
using BlockId = std::size_t;

/// What the numbers of a block mean, as far as it matters when the whole map turns or grows; see State::correct.
enum class BlockKind {
  kPose,          ///< x, y [m], theta in the map
  kFreePose,      ///< x, y, z [m] and the rotation's quaternion (x, y, z, w); its error: six numbers, see BodyPose
  kPoint,         ///< x, y, z [m] in the map
  kInverseDepth,  ///< a ray relative to a pose and, third, an inverse depth [1/m]
  kCalibration,   ///< first, the relative error of the odometry's scale of distance
  kVelocity,      ///< first, the relative error of the map's unit; second, a speed [1/s]
  kFreeVelocity,  ///< the same with three numbers for the velocity [1/s], in the axes of base_link
};

/// Which of the numbers of a BlockKind::kVelocity the speed is.
inline constexpr int kSpeedIndex = 1;

/// The most columns a Jacobian part may have: the 13 numbers of a free camera (seed 002 section 2.2).
inline constexpr int kMaxBlockSize = 13;

/// Part of a Jacobian: its columns for one block, the other columns being zero.
template <int Rows>
struct JacobianPart {
  BlockId block = 0;
  Eigen::Matrix<double, Rows, Eigen::Dynamic, Rows == 1 ? Eigen::RowMajor : Eigen::ColMajor, Rows, kMaxBlockSize>
      matrix;
};

/// A linearised measurement of two numbers: residual = z - h(x), rows of H by block, noise covariance R.
struct LinearMeasurement {
  Eigen::Vector2d residual = Eigen::Vector2d::Zero();
  std::vector<JacobianPart<2>> jacobian;
  Eigen::Matrix2d noise = Eigen::Matrix2d::Identity();
};

/// Mean and dense covariance of everything the filter estimates, in blocks that come and go.
///
/// The first block is the robot's pose, the second the calibration of its odometry. A block has as many numbers in the
/// mean as in its error, except a kFreePose (7 and 6): sizes, offsets and Jacobians are those of the error.
class State {
 public:
  int size() const { return size_; }
  /// Where a block starts, -1 when it is gone.
  int offset(BlockId block) const { return blocks_[block].offset; }
  bool has(BlockId block) const { return block < blocks_.size() && blocks_[block].offset >= 0; }
  BlockKind kind(BlockId block) const { return blocks_[block].kind; }
  auto mean(BlockId block) const { return mean_.segment(blocks_[block].mean_offset, blocks_[block].mean_size()); }
  auto mean(BlockId block) { return mean_.segment(blocks_[block].mean_offset, blocks_[block].mean_size()); }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// The error the present mean would have if `mean` were right.
  Eigen::VectorXd error_given(const Eigen::VectorXd& mean) const;
  auto covariance() const { return covariance_.topLeftCorner(size_, size_); }
  auto covariance(BlockId row, BlockId column) const {
    return covariance_.block(offset(row), offset(column), blocks_[row].size, blocks_[column].size);
  }

  /// Adds a block whose error is sum_k J_k e_k + noise.
  BlockId append(const Eigen::VectorXd& mean, BlockKind kind, std::span<const JacobianPart<Eigen::Dynamic>> parts,
                 const Eigen::MatrixXd& noise);
  /// Replaces a block by a function of blocks (maybe itself): its error becomes sum_k J_k e_k + noise.
  void transform(BlockId block, const Eigen::VectorXd& mean, BlockKind kind,
                 std::span<const JacobianPart<Eigen::Dynamic>> parts, const Eigen::MatrixXd& noise);
  void remove(std::span<const BlockId> blocks);

  /// P H^T (size x 2m) of stacked measurements.
  Eigen::MatrixXd covariance_times_jacobian(std::span<const LinearMeasurement> measurements) const;
  /// H M (2m x columns of M) for the stacked H.
  Eigen::MatrixXd jacobian_times(std::span<const LinearMeasurement> measurements, const Eigen::MatrixXd& m) const;

  /// Moves the mean by `delta` and carries the covariance along.
  ///
  /// No measurement sees the map turn about its origin, and without lever arms none sees it grow: along these
  /// directions, (1, J p) and (1, p) for every position p (J: quarter turn), (1, -rho) for inverse depths, a filter
  /// must stay as uncertain as it was. A plain EKF evaluates them at estimates that change and gains false certainty;
  /// what is worse, the errors of depth and of innovation are correlated then and pull the scale down image by image.
  /// Adding to the error of a position that moves by d what the heading's and the scale's error make of d, J d and d,
  /// keeps both directions exactly. This is the right-invariant EKF in ordinary coordinates (Barrau and Bonnabel 2015,
  /// not in the seeds), with the scale beside the heading. A free robot has three such turns, e x d, for its heading.
  void correct(const Eigen::VectorXd& delta);
  /// Corrects one block alone by one measured number, residual = h^T e + noise, and takes all other blocks as they are
  /// (Schmidt's consider update): their uncertainty counts, but they learn nothing.
  void correct_alone(BlockId block, double residual, std::span<const JacobianPart<1>> jacobian, double variance);
  /// P <- factor P: the estimate turned out to be less certain than it says.
  void inflate(double factor) { covariance_.topLeftCorner(size_, size_) *= factor; }
  /// P <- P + e e^T: an error that is independent of all others.
  void add_error(const Eigen::VectorXd& e) { covariance_.topLeftCorner(size_, size_).noalias() += e * e.transpose(); }
  /// P <- P - Y Y^T.
  void subtract_outer_product(const Eigen::MatrixXd& y);

 private:
  struct Block {
    int offset;
    int size;
    int mean_offset;
    BlockKind kind;

    int mean_size() const { return kind == BlockKind::kFreePose ? size + 1 : size; }
  };

  /// What the error of one number adds to the errors of all.
  struct Dependence {
    int index;
    Eigen::VectorXd c;
  };

  Eigen::MatrixXd combine_rows(std::span<const JacobianPart<Eigen::Dynamic>> parts, int rows) const;
  void reserve(int size);
  void retract(const Eigen::VectorXd& delta);
  void add(std::span<const Dependence> dependences);

  std::vector<Block> blocks_;   // by id
  std::vector<BlockId> alive_;  // in the order of their offsets
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;  // symmetric, at least size_ x size_
  int size_ = 0;
};

}  // namespace slamfuse::visual_slam
