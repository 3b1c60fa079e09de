// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/slip_watch.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "visual_slam/consensus.hpp"

namespace slamfuse::visual_slam {
namespace {

constexpr double kBelieved = 16.0;        // twice the log likelihood ratio, 3000 to 1; good runs stay below 14.1
constexpr double kMostEvidence = 10.0;    // of one image: a bad one alone does not decide
constexpr double kMostSuspicion = 32.0;   // so that it can be forgotten again
constexpr double kLongest = 10.0;         // [s] of a slip, and between two
constexpr std::size_t kFewWitnesses = 8;  // measurements that must agree on it

}  // namespace

SlipEvidence slip_evidence(const Eigen::VectorXd& innovations, const Eigen::MatrixXd& covariance,
                           const Eigen::Matrix<double, Eigen::Dynamic, 2>& by_slip, double gate) {
  const Consensus agreeing = find_consensus(innovations, covariance + by_slip * by_slip.transpose(), gate);
  if (agreeing.accepted.size() < kFewWitnesses) return {};
  std::vector<int> rows;
  for (const int i : agreeing.accepted) rows.insert(rows.end(), {2 * i, 2 * i + 1});
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance(rows, rows));
  const Eigen::MatrixXd whitened_slip = llt.matrixL().solve(by_slip(rows, Eigen::all));
  const Eigen::VectorXd whitened = llt.matrixL().solve(innovations(rows));
  // By Woodbury's identity nu^T S^-1 nu - nu^T (S + D D^T)^-1 nu and the ratio of the determinants are small problems.
  const Eigen::Matrix2d information = Eigen::Matrix2d::Identity() + whitened_slip.transpose() * whitened_slip;
  const Eigen::Vector2d pull = whitened_slip.transpose() * whitened;
  const Eigen::Vector2d likely = information.inverse() * pull;
  const Eigen::Vector2d shown = likely.cwiseProduct(pull);
  return {.evidence = shown.sum() - std::log(information.determinant()),
          .share = shown[0] > shown[1] ? likely[0] : likely[1]};
}

void SlipWatch::move(const Slip& slip, const Eigen::Vector2d& way, double seconds) {
  if (changed_) *changed_ += seconds;
  if (!since_image_) {
    since_image_ = slip;
    return;
  }
  since_image_->pose.topRows<2>() += Eigen::Vector2d(-way.y(), way.x()) * since_image_->pose.row(2);
  since_image_->pose += slip.pose;
}

SlipWatch::Verdict SlipWatch::judge(const SlipEvidence& image) {
  suspicion_ = std::clamp(suspicion_ + std::min(image.evidence, kMostEvidence), 0.0, kMostSuspicion);
  if (slipping_ && *changed_ > kLongest) slipping_ = false;
  if (suspicion_ <= kBelieved || (!slipping_ && changed_ && *changed_ < kLongest)) return Verdict::kNothing;
  if ((image.share > 0.0) != slipping_) return Verdict::kNothing;
  slipping_ = !slipping_;
  changed_ = 0.0;
  suspicion_ = 0.0;
  return slipping_ ? Verdict::kSlip : Verdict::kGrip;
}

bool SlipWatch::doubtful() const { return slipping_ || suspicion_ > kBelieved; }

}  // namespace slamfuse::visual_slam
