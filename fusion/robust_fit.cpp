// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/robust_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "common/median.hpp"
#include "fusion/robust_statistics.hpp"

namespace slamfuse::fusion {
namespace {

/// The noise is measured at this quantile of the residuals. Less than the median, so that half of the pairs and
/// somewhat more may be outliers.
constexpr double kQuantile = 0.4;
/// That quantile of a Rayleigh distribution [standard deviations of one coordinate]: sqrt(-2 ln(1 - kQuantile)).
constexpr double kRayleighQuantile = 1.0107676525947897;
/// Noise below this part of the path's extent is rounding.
constexpr double kSmallestRelativeSigma = 1e-9;
/// A sample whose visual points lie closer than this part of the extent, or whose triangle is thinner, fixes nothing.
constexpr double kSmallestSampleSpread = 0.05;
/// Stretch of one direction over the other beyond which a sample is not a map of the same drive.
constexpr double kLargestAnisotropy = 5.0;

using Points = std::vector<Eigen::Vector2d>;

/// Both paths with their centroids taken off, so that the normal equations are well conditioned wherever the maps lie.
struct CentredPaths {
  Points laser;
  Points visual;
  Eigen::Vector2d laser_centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d visual_centre = Eigen::Vector2d::Zero();
  double laser_spread = 0.0;   ///< median distance from the centre
  double visual_spread = 0.0;  ///< the same
};

Eigen::Vector2d median_point(const Points& points) {
  std::vector<double> values(points.size());
  Eigen::Vector2d centre;
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    centre[axis] = common::median(values);
  }
  return centre;
}

double median_distance(const Points& points) {
  std::vector<double> values(points.size());
  std::transform(points.begin(), points.end(), values.begin(), [](const Eigen::Vector2d& p) { return p.norm(); });
  return common::median(std::move(values));
}

CentredPaths centre(const std::vector<PosePair>& pairs) {
  CentredPaths paths;
  for (const PosePair& pair : pairs) {
    paths.laser.push_back(pair.laser.translation());
    paths.visual.push_back(pair.visual.translation());
  }
  paths.laser_centre = median_point(paths.laser);
  paths.visual_centre = median_point(paths.visual);
  for (Eigen::Vector2d& point : paths.laser) point -= paths.laser_centre;
  for (Eigen::Vector2d& point : paths.visual) point -= paths.visual_centre;
  paths.laser_spread = median_distance(paths.laser);
  paths.visual_spread = median_distance(paths.visual);
  return paths;
}

double rotation_of(const PlanarAffine& map) {
  return std::atan2(map.linear(1, 0) - map.linear(0, 1), map.linear(0, 0) + map.linear(1, 1));
}

/// The rigid map nearest to a similarity that keeps `centre` where that maps it. (Of all rigid maps it has the least
/// squares if the similarity has them among similarities and `centre` is the weighted centroid.)
PlanarAffine without_scale(const PlanarAffine& similarity, const Eigen::Vector2d& centre) {
  PlanarAffine rigid;
  rigid.linear = similarity.linear / std::sqrt(similarity.linear.determinant());
  rigid.translation = similarity * centre - rigid.linear * centre;
  return rigid;
}

std::optional<PlanarAffine> similarity_through(const CentredPaths& paths, std::size_t i, std::size_t j) {
  const Eigen::Vector2d from = paths.visual[j] - paths.visual[i];
  const Eigen::Vector2d to = paths.laser[j] - paths.laser[i];
  if (from.norm() < kSmallestSampleSpread * paths.visual_spread) return std::nullopt;
  const double along = from.dot(to) / from.squaredNorm();
  const double across = (from.x() * to.y() - from.y() * to.x()) / from.squaredNorm();
  PlanarAffine map;
  map.linear << along, -across, across, along;
  map.translation = paths.laser[i] - map.linear * paths.visual[i];
  return map;
}

std::optional<PlanarAffine> affine_through(const CentredPaths& paths, std::size_t i, std::size_t j, std::size_t k) {
  Eigen::Matrix2d from;
  from << paths.visual[j] - paths.visual[i], paths.visual[k] - paths.visual[i];
  const double smallest_area = kSmallestSampleSpread * paths.visual_spread * paths.visual_spread;
  if (std::abs(from.determinant()) < smallest_area) return std::nullopt;
  Eigen::Matrix2d to;
  to << paths.laser[j] - paths.laser[i], paths.laser[k] - paths.laser[i];
  PlanarAffine map;
  map.linear = to * from.inverse();
  map.translation = paths.laser[i] - map.linear * paths.visual[i];
  const double determinant = map.linear.determinant();
  // |A|^2 / (2 det) = (r + 1/r) / 2 for the ratio r of the singular values.
  const double mean_stretch = 0.5 * map.linear.squaredNorm();
  if (determinant <= 0.0 || mean_stretch > 0.5 * (kLargestAnisotropy + 1.0 / kLargestAnisotropy) * determinant) {
    return std::nullopt;
  }
  return map;
}

std::vector<PlanarAffine> random_hypotheses(const CentredPaths& paths, RobustModel model,
                                            const RobustFitOptions& options) {
  std::mt19937_64 engine(static_cast<std::uint64_t>(options.seed));
  // The engine is the same everywhere, the standard's distributions are not.
  const auto draw = [&] { return static_cast<std::size_t>(engine() % paths.laser.size()); };
  std::vector<PlanarAffine> hypotheses;
  hypotheses.reserve(static_cast<std::size_t>(options.hypotheses));
  for (int n = 0; n < options.hypotheses; ++n) {
    const std::size_t i = draw();
    const std::size_t j = draw();
    const std::size_t k = draw();
    auto map = model == RobustModel::kAffine ? affine_through(paths, i, j, k) : similarity_through(paths, i, j);
    if (map && map->linear.determinant() <= 0.0) continue;
    if (map && model == RobustModel::kRigid) map = without_scale(*map, 0.5 * (paths.visual[i] + paths.visual[j]));
    if (map) hypotheses.push_back(*map);
  }
  return hypotheses;
}

/// The paths thinned evenly to at most `count` points.
CentredPaths thin(const CentredPaths& paths, std::size_t count) {
  CentredPaths thinned = paths;
  thinned.laser = evenly_spread(paths.laser, count);
  thinned.visual = evenly_spread(paths.visual, count);
  return thinned;
}

void squared_residuals(const CentredPaths& paths, const PlanarAffine& map, std::vector<double>& squares) {
  squares.resize(paths.laser.size());
  for (std::size_t i = 0; i < squares.size(); ++i) squares[i] = (paths.laser[i] - map * paths.visual[i]).squaredNorm();
}

/// Robust standard deviation of one coordinate; partially sorts `squares`.
double sigma_of(std::vector<double>& squares, double floor) {
  const auto place = static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(squares.size()));
  std::nth_element(squares.begin(), squares.begin() + place, squares.end());
  return std::max(std::sqrt(squares[static_cast<std::size_t>(place)]) / kRayleighQuantile, floor);
}

/// sigma_of where it is below `best`, else nothing: most hypotheses are bad, and that is seen without sorting, mostly
/// before all of the pairs were looked at. `squares` is room to work in.
std::optional<double> sigma_below(const CentredPaths& paths, const PlanarAffine& map, double best, double floor,
                                  std::vector<double>& squares) {
  constexpr double kRounding = 1.0 + 1e-9;
  const std::size_t count = paths.laser.size();
  const auto place = static_cast<std::size_t>(kQuantile * static_cast<double>(count));
  const std::size_t most_above = count - place - 1;
  const double bound = best * best * kRayleighQuantile * kRayleighQuantile * kRounding;
  std::size_t above = 0;
  squares.resize(count);
  for (std::size_t i = 0; i < count && above <= most_above; ++i) {
    squares[i] = (paths.laser[i] - map * paths.visual[i]).squaredNorm();
    above += squares[i] >= bound ? 1 : 0;
  }
  if (above > most_above) return std::nullopt;
  const double sigma = sigma_of(squares, floor);
  return sigma < best ? std::optional(sigma) : std::nullopt;
}

/// Mean of the squared residuals, each cut off at `bound`; infinite as soon as it is known to be above `limit`.
double truncated_loss(const CentredPaths& paths, const PlanarAffine& map, double bound,
                      double limit = std::numeric_limits<double>::infinity()) {
  const double count = static_cast<double>(paths.laser.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < paths.laser.size(); ++i) {
    sum += std::min((paths.laser[i] - map * paths.visual[i]).squaredNorm(), bound);
    if (sum > limit * count) return std::numeric_limits<double>::infinity();
  }
  return sum / count;
}

/// How the six numbers of an affine map follow from the model's own; of a rigid one: change with them at `map`.
Eigen::MatrixXd parameter_basis(RobustModel model, const PlanarAffine& map) {
  if (model == RobustModel::kAffine) return Eigen::MatrixXd::Identity(6, 6);
  if (model == RobustModel::kRigid) {
    Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(6, 3);  // (angle, tx, ty) of [cos -sin; sin cos]
    basis.topLeftCorner<4, 1>() << -map.linear(1, 0), -map.linear(0, 0), map.linear(0, 0), -map.linear(1, 0);
    basis(4, 1) = basis(5, 2) = 1.0;
    return basis;
  }
  Eigen::MatrixXd basis = Eigen::MatrixXd::Zero(6, 4);  // (a, b, tx, ty) of [a -b; b a]
  basis(0, 0) = basis(3, 0) = 1.0;
  basis(1, 1) = -1.0;
  basis(2, 1) = 1.0;
  basis(4, 2) = basis(5, 3) = 1.0;
  return basis;
}

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Weighted normal equations in the six numbers (linear row by row, then translation).
struct NormalEquations {
  Matrix6 matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
};

NormalEquations normal_equations(const CentredPaths& paths, const std::vector<double>& weights) {
  // Both coordinates share the moments of (x, y, 1).
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> products = Eigen::Matrix<double, 3, 2>::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] == 0.0) continue;
    const Eigen::Vector3d row = paths.visual[i].homogeneous();
    moments.noalias() += weights[i] * row * row.transpose();
    products.noalias() += weights[i] * row * paths.laser[i].transpose();
  }
  constexpr std::array<std::array<int, 3>, 2> kPlaces = {{{0, 1, 4}, {2, 3, 5}}};
  NormalEquations equations;
  for (int axis = 0; axis < 2; ++axis) {
    for (int r = 0; r < 3; ++r) {
      equations.right[kPlaces[axis][r]] = products(r, axis);
      for (int c = 0; c < 3; ++c) equations.matrix(kPlaces[axis][r], kPlaces[axis][c]) = moments(r, c);
    }
  }
  return equations;
}

PlanarAffine to_map(const Vector6& p) {
  PlanarAffine map;
  map.linear << p[0], p[1], p[2], p[3];
  map.translation << p[4], p[5];
  return map;
}

std::optional<PlanarAffine> weighted_fit(const CentredPaths& paths, const std::vector<double>& weights,
                                         RobustModel model) {
  const NormalEquations equations = normal_equations(paths, weights);
  const RobustModel linear = model == RobustModel::kRigid ? RobustModel::kSimilarity : model;
  const Eigen::MatrixXd basis = parameter_basis(linear, {});
  const Eigen::MatrixXd matrix = basis.transpose() * equations.matrix * basis;
  const Eigen::LDLT<Eigen::MatrixXd> solver(matrix);
  if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
  const PlanarAffine map = to_map(basis * solver.solve(basis.transpose() * equations.right));
  if (!map.is_finite() || map.linear.determinant() <= 0.0) return std::nullopt;
  if (model != RobustModel::kRigid) return map;
  const Eigen::Vector2d centroid = equations.matrix.block<1, 2>(4, 0).transpose() / equations.matrix(4, 4);
  return without_scale(map, centroid);
}

/// The same of the residuals within `bound_sigmas` of it, repeated until it settles: the quantile of all residuals lies
/// in the tail of the good ones where many are outliers.
double inlier_sigma(std::vector<double> squares, double sigma, double bound_sigmas, double floor) {
  constexpr int kRounds = 5;
  for (int n = 0; n < kRounds; ++n) {
    const double bound = bound_sigmas * bound_sigmas * sigma * sigma;
    std::erase_if(squares, [&](double square) { return square > bound; });
    if (squares.empty()) return sigma;
    const double next = sigma_of(squares, floor);
    if (next >= sigma) return sigma;
    sigma = next;
  }
  return sigma;
}

/// Iterated reweighted least squares; the noise level is re-estimated until it settles, never upwards.
PlanarAffine refine(const CentredPaths& paths, PlanarAffine map, RobustModel model, int iterations, double sigma_floor,
                    double& sigma) {
  constexpr double kSettled = 1e-9;  // relative change of the linear part
  std::vector<double> squares;
  std::vector<double> sorted;
  std::vector<double> weights(paths.laser.size());
  for (int n = 0; n < iterations; ++n) {
    squared_residuals(paths, map, squares);
    sorted = squares;
    sigma = std::min(sigma, sigma_of(sorted, sigma_floor));
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = tukey_weight(squares[i], sigma);
    const auto next = weighted_fit(paths, weights, model);
    if (!next) return map;
    const double change = (next->linear - map.linear).norm() / map.linear.norm();
    map = *next;
    if (change < kSettled) break;
  }
  return map;
}

/// Covariance of the fit by the sandwich of M-estimation with Tukey's psi over the inliers, inflated by the first
/// autocorrelation of the residuals (a first-order process has n (1 - r) / (1 + r) independent samples).
Matrix6 covariance_of(const CentredPaths& paths, const PlanarAffine& map, RobustModel model, double sigma,
                      const std::vector<bool>& inliers) {
  const Eigen::MatrixXd basis = parameter_basis(model, map);
  constexpr double kLargestAutocorrelation = 0.99;
  std::vector<double> ones(paths.laser.size(), 0.0);
  double slope = 0.0;
  double square = 0.0;
  double count = 0.0;
  double lagged = 0.0;
  double total = 0.0;
  Eigen::Vector2d previous = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < paths.laser.size(); ++i) {
    if (!inliers[i]) continue;
    const Eigen::Vector2d residual = paths.laser[i] - map * paths.visual[i];
    const double u2 = residual.squaredNorm() / (kTukeyConstant * kTukeyConstant * sigma * sigma);
    if (u2 >= 1.0) continue;  // an inlier by a wide setting that has no weight in the fit
    const double weight = (1.0 - u2) * (1.0 - u2);
    slope += weight - 2.0 * u2 * (1.0 - u2);
    square += 0.5 * weight * weight * residual.squaredNorm();
    lagged += residual.dot(previous);
    total += residual.squaredNorm();
    previous = residual;
    ones[i] = 1.0;
    count += 1.0;
  }
  if (count < 4.0 || !(slope > 0.0)) return Matrix6::Zero();
  const double autocorrelation = total > 0.0 ? std::clamp(lagged / total, 0.0, kLargestAutocorrelation) : 0.0;
  const double inflation = (1.0 + autocorrelation) / (1.0 - autocorrelation);
  const double parameters = 0.5 * static_cast<double>(basis.cols());
  const double variance = square * count * count / ((count - parameters) * slope * slope);
  const Eigen::MatrixXd information = basis.transpose() * normal_equations(paths, ones).matrix * basis;
  const Eigen::MatrixXd inverse =
      information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
  return inflation * variance * basis * inverse * basis.transpose();
}

/// The smallest truncated loss of maps whose rotation is well separated from the best one's: of the random hypotheses
/// and of the best of them refined.
double runner_up_loss(const CentredPaths& scored, const std::vector<PlanarAffine>& hypotheses, const PlanarAffine& best,
                      double separation, double bound, RobustModel model) {
  constexpr int kRefinements = 5;
  double smallest = bound;  // what a map that fits no pair loses
  std::optional<PlanarAffine> runner_up;
  const auto separated = [&](const PlanarAffine& map) {
    return std::abs(common::angle_difference(rotation_of(map), rotation_of(best))) > separation;
  };
  for (const PlanarAffine& map : hypotheses) {
    if (!separated(map)) continue;
    const double loss = truncated_loss(scored, map, bound, smallest);
    if (loss < smallest) {
      smallest = loss;
      runner_up = map;
    }
  }
  std::vector<double> squares;
  std::vector<double> weights(scored.laser.size());
  for (int n = 0; runner_up && n < kRefinements; ++n) {
    squared_residuals(scored, *runner_up, squares);
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = squares[i] < bound ? 1.0 : 0.0;
    runner_up = weighted_fit(scored, weights, model);
    if (!runner_up || !separated(*runner_up)) break;
    smallest = std::min(smallest, truncated_loss(scored, *runner_up, bound));
  }
  return smallest;
}

/// Covariance of the map between the paths as given from that between the centred paths: t = t_c + c_L - A c_V.
Matrix6 uncentre(const Matrix6& covariance, const Eigen::Vector2d& visual_centre) {
  Matrix6 jacobian = Matrix6::Identity();
  jacobian.block<1, 2>(4, 0) = -visual_centre.transpose();
  jacobian.block<1, 2>(5, 2) = -visual_centre.transpose();
  return jacobian * covariance * jacobian.transpose();
}

}  // namespace

std::optional<RobustFit> fit_robust(const std::vector<PosePair>& pairs, RobustModel model,
                                    const RobustFitOptions& options, double runner_up_separation) {
  if (pairs.size() < 3) return std::nullopt;
  const CentredPaths paths = centre(pairs);
  if (!(paths.laser_spread > 0.0) || !(paths.visual_spread > 0.0)) return std::nullopt;
  const CentredPaths scored = thin(paths, static_cast<std::size_t>(options.scored_pairs));
  const double sigma_floor = kSmallestRelativeSigma * paths.laser_spread;

  const std::vector<PlanarAffine> hypotheses = random_hypotheses(paths, model, options);
  std::optional<PlanarAffine> best;
  double sigma = std::numeric_limits<double>::infinity();
  std::vector<double> squares;
  for (const PlanarAffine& map : hypotheses) {
    if (const auto candidate = sigma_below(scored, map, sigma, sigma_floor, squares)) {
      sigma = *candidate;
      best = map;
    }
  }
  if (!best) return std::nullopt;

  RobustFit fit;
  PlanarAffine map = refine(paths, *best, model, options.iterations, sigma_floor, sigma);
  squared_residuals(paths, map, squares);
  sigma = inlier_sigma(squares, sigma, options.inlier_sigmas, sigma_floor);
  map = refine(paths, map, model, options.iterations, sigma_floor, sigma);
  fit.sigma = sigma;
  const double bound = options.inlier_sigmas * options.inlier_sigmas * sigma * sigma;
  squared_residuals(paths, map, squares);
  fit.inliers.resize(pairs.size());
  for (std::size_t i = 0; i < squares.size(); ++i) fit.inliers[i] = squares[i] <= bound;
  fit.covariance = uncentre(covariance_of(paths, map, model, sigma, fit.inliers), paths.visual_centre);
  fit.loss = truncated_loss(scored, map, bound);
  fit.runner_up_loss = runner_up_loss(scored, hypotheses, map, runner_up_separation, bound, model);
  fit.map.linear = map.linear;
  fit.map.translation = map.translation + paths.laser_centre - map.linear * paths.visual_centre;
  return fit;
}

}  // namespace slamfuse::fusion
