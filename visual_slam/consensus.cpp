// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/consensus.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace slamfuse::visual_slam {
namespace {

double normalised_square(const Eigen::Vector2d& innovation, const Eigen::Matrix2d& covariance) {
  return innovation.dot(covariance.inverse() * innovation);
}

/// The normalised squares of all gated measurements given that measurement `believed` is right.
std::vector<double> squares_given(int believed, const std::vector<int>& gated, const Eigen::VectorXd& innovation,
                                  const Eigen::MatrixXd& covariance) {
  const Eigen::Matrix2d inverse = covariance.block<2, 2>(2 * believed, 2 * believed).inverse();
  const Eigen::Vector2d scaled = inverse * innovation.segment<2>(2 * believed);
  std::vector<double> squares;
  squares.reserve(gated.size());
  for (const int other : gated) {
    if (other == believed) {
      squares.push_back(0.0);
      continue;
    }
    const Eigen::Matrix2d cross = covariance.block<2, 2>(2 * other, 2 * believed);
    const Eigen::Matrix2d remaining =
        covariance.block<2, 2>(2 * other, 2 * other) - cross * inverse * cross.transpose();
    squares.push_back(normalised_square(innovation.segment<2>(2 * other) - cross * scaled, remaining));
  }
  return squares;
}

/// Grows the Cholesky factor of the accepted measurements' covariance one measurement at a time.
class JointTest {
 public:
  JointTest(const Eigen::VectorXd& innovation, const Eigen::MatrixXd& covariance, std::size_t capacity)
      : innovation_(innovation),
        covariance_(covariance),
        factor_(Eigen::MatrixXd::Zero(2 * static_cast<int>(capacity), 2 * static_cast<int>(capacity))),
        whitened_(2 * static_cast<int>(capacity)) {}

  bool accept(int candidate, double gate) {
    const int known = 2 * static_cast<int>(accepted_.size());
    Eigen::MatrixXd cross(known, 2);
    for (std::size_t i = 0; i < accepted_.size(); ++i) {
      cross.middleRows<2>(2 * static_cast<int>(i)) = covariance_.block<2, 2>(2 * accepted_[i], 2 * candidate);
    }
    factor_.topLeftCorner(known, known).triangularView<Eigen::Lower>().solveInPlace(cross);
    const Eigen::Matrix2d remaining = covariance_.block<2, 2>(2 * candidate, 2 * candidate) - cross.transpose() * cross;
    const Eigen::LLT<Eigen::Matrix2d> llt(remaining);
    if (llt.info() != Eigen::Success) return false;
    const Eigen::Vector2d whitened =
        llt.matrixL().solve(innovation_.segment<2>(2 * candidate) - cross.transpose() * whitened_.head(known));
    if (!(whitened.squaredNorm() <= gate)) return false;
    factor_.block(known, 0, 2, known) = cross.transpose();
    factor_.block<2, 2>(known, known) = llt.matrixL();
    whitened_.segment<2>(known) = whitened;
    accepted_.push_back(candidate);
    return true;
  }

  Consensus result() && {
    const int dimension = 2 * static_cast<int>(accepted_.size());
    const double nis = dimension == 0 ? 0.0 : whitened_.head(dimension).squaredNorm() / dimension;
    std::sort(accepted_.begin(), accepted_.end());
    return {std::move(accepted_), nis};
  }

 private:
  const Eigen::VectorXd& innovation_;
  const Eigen::MatrixXd& covariance_;
  std::vector<int> accepted_;
  Eigen::MatrixXd factor_;
  Eigen::VectorXd whitened_;
};

}  // namespace

double chi_square_gate_2(double probability) { return -2.0 * std::log(1.0 - probability); }

Consensus find_consensus(const Eigen::VectorXd& innovation, const Eigen::MatrixXd& covariance, double gate) {
  const int count = static_cast<int>(innovation.size()) / 2;
  std::vector<int> gated;
  for (int i = 0; i < count; ++i) {
    if (normalised_square(innovation.segment<2>(2 * i), covariance.block<2, 2>(2 * i, 2 * i)) <= gate) {
      gated.push_back(i);
    }
  }
  std::size_t best_support = 0;
  double best_sum = std::numeric_limits<double>::infinity();
  std::vector<double> best_squares;
  for (const int believed : gated) {
    std::vector<double> squares = squares_given(believed, gated, innovation, covariance);
    std::size_t support = 0;
    double sum = 0.0;
    for (const double square : squares) {
      if (square <= gate) ++support;
      sum += std::min(square, gate);
    }
    if (support > best_support || (support == best_support && sum < best_sum)) {
      best_support = support;
      best_sum = sum;
      best_squares = std::move(squares);
    }
  }
  std::vector<std::size_t> order(gated.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&best_squares](std::size_t a, std::size_t b) { return best_squares[a] < best_squares[b]; });
  JointTest test(innovation, covariance, gated.size());
  for (const std::size_t i : order) test.accept(gated[i], gate);
  return std::move(test).result();
}

}  // namespace slamfuse::visual_slam
