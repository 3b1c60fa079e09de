// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/hypothesis_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

#include "common/angle.hpp"
#include "laser_slam/motion_model.hpp"
#include "laser_slam/resampling.hpp"

namespace slamfuse::laser_slam {

int kld_particles(int bins, double error, double quantile) {
  if (bins <= 1) return 1;
  const double k = bins - 1;
  const double a = 2.0 / (9.0 * k);
  const double root = 1.0 - a + std::sqrt(a) * quantile;
  return static_cast<int>(std::ceil(k / (2.0 * error) * root * root * root));
}

HypothesisFilter::HypothesisFilter(const HypothesisFilterOptions& options, std::uint64_t seed)
    : options_(options), random_(seed, 0) {}

double HypothesisFilter::gain(std::size_t beams) const {
  return std::min(1.0, options_.effective_beams / std::max(1.0, static_cast<double>(beams)));
}

void HypothesisFilter::clear() { groups_.clear(); }

void HypothesisFilter::add(const common::Pose2& mean, const Eigen::Matrix3d& covariance, double log_mass, int most) {
  Group group{next_id_++, log_mass, {}};
  const auto draw = [&](int count) {
    while (static_cast<int>(group.particles.size()) < count) {
      group.particles.push_back({draw_pose(mean, covariance, random_), 1.0});
    }
  };
  draw(std::min(options_.min_particles, most));
  // The wider the spread the more bins are met while drawing: Fox's loop, a batch at a time.
  const auto needed = [&] { return std::min(most, particles_needed(group.particles)); };
  for (int wanted = needed(); static_cast<int>(group.particles.size()) < wanted; wanted = needed()) {
    draw(std::min(wanted, static_cast<int>(group.particles.size()) + options_.min_particles));
  }
  for (Particle& particle : group.particles) particle.weight = 1.0 / static_cast<double>(group.particles.size());
  groups_.push_back(std::move(group));
  rank();
}

void HypothesisFilter::move(const common::Pose2& increment, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d root = covariance.llt().matrixL();
  for (Group& group : groups_) {
    for (Particle& particle : group.particles) {
      const Eigen::Vector3d noise = root * random_.normal3();
      particle.pose = particle.pose * increment * common::Pose2{noise.x(), noise.y(), noise.z()};
    }
  }
}

void HypothesisFilter::weigh(const BeamModel& model, const std::vector<Eigen::Vector2d>& points,
                             const Eigen::Vector2d& mount) {
  if (groups_.empty()) return;
  for (Group& group : groups_) weigh(group, model, points, mount);
  rank();
  join_those_that_met();
  give_up_improbable();
  const std::vector<Hypothesis> known = hypotheses();
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const auto count = static_cast<double>(groups_[i].particles.size());
    if (known[i].effective_particles >= options_.resample_threshold * count) continue;
    resample(groups_[i], static_cast<int>(known[i].mass * options_.max_particles));
  }
}

void HypothesisFilter::weigh(Group& group, const BeamModel& model, const std::vector<Eigen::Vector2d>& points,
                             const Eigen::Vector2d& mount) {
  const double scan_gain = gain(points.size());
  std::vector<double> log_weights;
  log_weights.reserve(group.particles.size());
  const Particle* heaviest = nullptr;
  double heaviest_likelihood = 0.0;
  for (const Particle& particle : group.particles) {
    const double likelihood = model.log_likelihood(points, particle.pose);
    log_weights.push_back(std::log(particle.weight) + scan_gain * likelihood);
    if (heaviest && log_weights.back() <= log_weights[static_cast<std::size_t>(heaviest - group.particles.data())]) {
      continue;
    }
    heaviest = &particle;
    heaviest_likelihood = likelihood;
  }
  const double largest = *std::max_element(log_weights.begin(), log_weights.end());
  if (!std::isfinite(largest)) return;
  double sum = 0.0;
  for (double& value : log_weights) {
    value = std::exp(value - largest);
    sum += value;
  }
  for (std::size_t i = 0; i < log_weights.size(); ++i) group.particles[i].weight = log_weights[i] / sum;
  const double through_walls = model.traced_log_likelihood(points, mount, heaviest->pose) - heaviest_likelihood;
  group.log_mass = options_.memory * group.log_mass + largest + std::log(sum) + scan_gain * through_walls;
}

void HypothesisFilter::resample(Group& group, int most) {
  std::vector<double> weights;
  weights.reserve(group.particles.size());
  for (const Particle& particle : group.particles) weights.push_back(particle.weight);
  const std::vector<int> parents = systematic_resampling(weights, random_.uniform());
  std::vector<Particle> children;
  children.reserve(parents.size());
  for (const int parent : parents) children.push_back(group.particles[static_cast<std::size_t>(parent)]);
  const int wanted =
      std::max(options_.min_particles, std::min(particles_needed(children), std::max(most, options_.min_particles)));
  // Systematic again, now evenly: more children repeat, fewer are an even choice.
  group.particles.clear();
  for (int i = 0; i < wanted; ++i) {
    const auto parent = static_cast<std::size_t>(i) * children.size() / static_cast<std::size_t>(wanted);
    group.particles.push_back({children[parent].pose, 1.0 / wanted});
  }
}

int HypothesisFilter::particles_needed(const std::vector<Particle>& particles) const {
  std::set<std::array<int, 3>> bins;
  for (const Particle& particle : particles) {
    bins.insert({static_cast<int>(std::floor(particle.pose.x / options_.bin_size)),
                 static_cast<int>(std::floor(particle.pose.y / options_.bin_size)),
                 static_cast<int>(std::floor(particle.pose.theta / options_.bin_angle))});
  }
  return std::clamp(kld_particles(static_cast<int>(bins.size()), options_.kld_error, options_.kld_quantile),
                    options_.min_particles, options_.max_particles);
}

void HypothesisFilter::rank() {
  std::stable_sort(groups_.begin(), groups_.end(),
                   [](const Group& a, const Group& b) { return a.log_mass > b.log_mass; });
  const double best = groups_.front().log_mass;
  for (Group& group : groups_) group.log_mass -= best;
}

void HypothesisFilter::join_those_that_met() {
  std::vector<Group> kept;
  std::vector<common::Pose2> means;
  for (Group& group : groups_) {
    const common::Pose2 mean = describe(group).mean;
    const auto met = std::find_if(means.begin(), means.end(), [&](const common::Pose2& other) {
      return std::hypot(mean.x - other.x, mean.y - other.y) < options_.merge_distance &&
             std::abs(common::angle_difference(mean.theta, other.theta)) < options_.merge_angle;
    });
    if (met == means.end()) {
      means.push_back(mean);
      kept.push_back(std::move(group));
      continue;
    }
    // Both tell of one place: the better one's particles tell it better, the older id says how long it is known.
    Group& other = kept[static_cast<std::size_t>(met - means.begin())];
    other.id = std::min(other.id, group.id);
  }
  groups_ = std::move(kept);
}

void HypothesisFilter::give_up_improbable() {
  const double least = std::log(std::max(options_.least_mass, 1e-300));
  std::erase_if(groups_, [&](const Group& group) { return group.log_mass < least; });
}

Hypothesis HypothesisFilter::describe(const Group& group) const {
  Hypothesis result;
  result.id = group.id;
  result.particles = static_cast<int>(group.particles.size());
  Eigen::Vector2d heading = Eigen::Vector2d::Zero();
  double heaviest = -1.0;
  double squares = 0.0;
  for (const Particle& particle : group.particles) {
    result.mean.x += particle.weight * particle.pose.x;
    result.mean.y += particle.weight * particle.pose.y;
    heading += particle.weight * Eigen::Vector2d(std::cos(particle.pose.theta), std::sin(particle.pose.theta));
    squares += particle.weight * particle.weight;
    if (particle.weight <= heaviest) continue;
    heaviest = particle.weight;
    result.best = particle.pose;
  }
  result.mean.theta = std::atan2(heading.y(), heading.x());
  result.effective_particles = squares > 0.0 ? 1.0 / squares : 0.0;
  for (const Particle& particle : group.particles) {
    const Eigen::Vector3d error(particle.pose.x - result.mean.x, particle.pose.y - result.mean.y,
                                common::angle_difference(particle.pose.theta, result.mean.theta));
    result.covariance += particle.weight * error * error.transpose();
  }
  return result;
}

std::vector<Hypothesis> HypothesisFilter::hypotheses() const {
  std::vector<Hypothesis> result;
  double sum = 0.0;
  for (const Group& group : groups_) {
    result.push_back(describe(group));
    result.back().mass = std::exp(group.log_mass);
    sum += result.back().mass;
  }
  for (Hypothesis& hypothesis : result) hypothesis.mass /= sum;
  return result;
}

int HypothesisFilter::particle_count() const {
  return std::accumulate(groups_.begin(), groups_.end(), 0,
                         [](int sum, const Group& group) { return sum + static_cast<int>(group.particles.size()); });
}

}  // namespace slamfuse::laser_slam
