// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/particle_filter.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/angle.hpp"
#include "laser_slam/motion_model.hpp"
#include "laser_slam/parallel_for.hpp"
#include "laser_slam/resampling.hpp"

namespace slamfuse::laser_slam {
namespace {

constexpr std::uint64_t kResamplingStream = 0;  // the particle slots' streams follow

}  // namespace

ParticleFilter::ParticleFilter(const FilterSettings& settings, const ScanMatcher& matcher, std::uint64_t seed,
                               int threads)
    : settings_(settings),
      matcher_(matcher),
      threads_(threads),
      resampling_stream_(seed, kResamplingStream),
      scratches_(static_cast<std::size_t>(std::max(threads, 1))),
      effective_(settings.particles) {
  for (int i = 0; i < settings.particles; ++i) {
    streams_.emplace_back(seed, kResamplingStream + 1 + static_cast<std::uint64_t>(i));
  }
}

void ParticleFilter::start(const common::Pose2& pose, const GridMap& map) {
  particles_.assign(streams_.size(), Particle{pose, 0.0, 0.0, map});
  best_ = 0;
  effective_ = settings_.particles;
  ancestry_.clear();
  record(std::vector<int>(streams_.size(), 0));
}

void ParticleFilter::scatter(const common::Pose2& mean, const Eigen::Matrix3d& covariance) {
  const std::vector<int> parents(streams_.size(), best_);
  const Particle parent = best();
  const bool mapped = parent.map.known_at(mean.translation());
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    particles_[i] = parent;
    particles_[i].log_weight = 0.0;
    particles_[i].pose = i == 0 ? mean : draw_pose(mean, covariance, streams_[i]);
    if (mapped && !parent.map.known_at(particles_[i].pose.translation())) particles_[i].pose = mean;
  }
  best_ = 0;
  effective_ = settings_.particles;
  record(parents);
}

void ParticleFilter::update(const ScanBeams& scan, const MotionSinceUpdate& motion, double path_length, bool map_scan) {
  const int count = static_cast<int>(particles_.size());
  std::vector<Proposal> proposals(particles_.size());
  parallel_for(count, threads_, [&](int i, int) {
    const auto slot = static_cast<std::size_t>(i);
    proposals[slot] = propose(particles_[slot], scan, motion);
  });

  const std::vector<int> parents = choose_parents(proposals);

  parallel_for(count, threads_, [&](int i, int worker) {
    const auto slot = static_cast<std::size_t>(i);
    const Proposal& proposal = proposals[static_cast<std::size_t>(parents[slot])];
    Particle& particle = particles_[slot];
    particle.pose = draw_pose(proposal.mean, proposal.covariance, streams_[slot]);
    if (map_scan) particle.map.insert(scan, particle.pose, path_length, scratches_[static_cast<std::size_t>(worker)]);
  });
  record(parents);
}

ParticleFilter::Proposal ParticleFilter::propose(const Particle& particle, const ScanBeams& scan,
                                                 const MotionSinceUpdate& motion) const {
  PosePrior prior;
  prior.mean = particle.pose * motion.increment;
  prior.information = to_parent_frame(motion.covariance, prior.mean).inverse();
  ScanMatch match = matcher_.match(particle.map, scan.match_points, particle.pose * motion.guess, prior);
  if (match.fit.agreement < settings_.lost_agreement) {
    match.pose = prior.mean;
    match.fit = matcher_.evaluate(particle.map, scan.match_points, prior.mean);
    match.fit.information.setZero();
  }
  const double gain = matcher_.gain();
  const Eigen::Matrix3d information = prior.information + gain * match.fit.information;
  const Eigen::Vector3d error(match.pose.x - prior.mean.x, match.pose.y - prior.mean.y,
                              common::angle_difference(match.pose.theta, prior.mean.theta));
  // eta = integral of p(z|x) p(x|u) = p(z|x*) p(x*|u) sqrt(det(2 pi Sigma)), with p(z|x) tempered by the gain.
  const double log_normalizer = gain * match.fit.log_likelihood - 0.5 * error.dot(prior.information * error) +
                                0.5 * std::log(prior.information.determinant() / information.determinant());
  const double spread = settings_.proposal_spread * settings_.proposal_spread;
  return {match.pose, spread * information.inverse(), log_normalizer};
}

std::vector<int> ParticleFilter::choose_parents(const std::vector<Proposal>& proposals) {
  std::vector<double> log_weights(particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].log_weight += proposals[i].log_normalizer;
    particles_[i].log_evidence += proposals[i].log_normalizer;
    log_weights[i] = particles_[i].log_weight;
  }
  const std::vector<double> weights = normalized_weights(log_weights);
  effective_ = effective_number(weights);
  std::vector<int> parents(particles_.size());
  std::iota(parents.begin(), parents.end(), 0);
  if (effective_ >= settings_.resample_threshold * static_cast<double>(particles_.size())) {
    best_ = most_evident();
    return parents;
  }

  parents = systematic_resampling(weights, resampling_stream_.uniform());
  std::vector<Particle> children;
  children.reserve(particles_.size());
  for (const int parent : parents) {
    children.push_back(particles_[static_cast<std::size_t>(parent)]);
    children.back().log_weight = 0.0;
  }
  particles_ = std::move(children);
  best_ = most_evident();
  return parents;
}

int ParticleFilter::most_evident() const {
  const auto most = std::max_element(particles_.begin(), particles_.end(), [](const Particle& a, const Particle& b) {
    return a.log_evidence < b.log_evidence;
  });
  return static_cast<int>(most - particles_.begin());
}

void ParticleFilter::record(const std::vector<int>& parents) {
  std::vector<Ancestry::Node> nodes;
  nodes.reserve(particles_.size());
  for (std::size_t i = 0; i < particles_.size(); ++i) nodes.push_back({particles_[i].pose, parents[i]});
  ancestry_.record(std::move(nodes));
}

Eigen::Matrix3d ParticleFilter::spread() const {
  std::vector<double> log_weights;
  for (const Particle& particle : particles_) log_weights.push_back(particle.log_weight);
  const std::vector<double> weights = normalized_weights(log_weights);
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  const common::Pose2& center = best().pose;
  for (std::size_t i = 0; i < particles_.size(); ++i) {
    const common::Pose2& pose = particles_[i].pose;
    const Eigen::Vector3d error(pose.x - center.x, pose.y - center.y,
                                common::angle_difference(pose.theta, center.theta));
    moment += weights[i] * error * error.transpose();
  }
  return moment;
}

}  // namespace slamfuse::laser_slam
