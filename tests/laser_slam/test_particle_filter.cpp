// SPDX-License-Identifier: BSD-3-Clause
#include "laser_slam/particle_filter.hpp"

#include <gtest/gtest.h>

#include "synthetic_room.hpp"

namespace slamfuse::laser_slam {
namespace {

class ParticleFilterTest : public ::testing::Test {
 protected:
  ParticleFilter filter(int threads, double resample_threshold = 0.5) {
    FilterSettings settings;
    settings.particles = 12;
    settings.resample_threshold = resample_threshold;
    ParticleFilter made(settings, ScanMatcher(ScanMatcherOptions{}, 0.05), 42, threads);
    GridMap map{MapOptions{}};
    InsertionScratch scratch;
    map.insert(beams_at({}), {}, 0.0, scratch);
    made.start({}, map);
    return made;
  }

  ScanBeams beams_at(const common::Pose2& pose) {
    return *project_scan(testing::scan_at(walls_, laser_, 0, pose), laser_, {}, Eigen::Vector3d::Zero());
  }

  /// Drives a curve with odometry that turns too little.
  void drive(ParticleFilter& filter, int steps) {
    const common::Pose2 step{0.1, 0.0, 0.1};
    truth_ = {};
    for (int i = 1; i <= steps; ++i) {
      truth_ = truth_ * step;
      MotionSinceUpdate motion;
      motion.increment = {0.11, 0.0, 0.07};
      motion.covariance = Eigen::Vector3d(4e-4, 4e-4, 2e-3).asDiagonal();
      motion.guess = motion.increment;
      filter.update(beams_at(truth_), motion, 0.1 * i, true);
    }
  }

  testing::Walls walls_ = testing::room();
  common::LaserCalibration laser_ = testing::full_circle_laser(120);
  common::Pose2 truth_;
};

TEST_F(ParticleFilterTest, FollowsTheScansWhereOdometryIsWrong) {
  ParticleFilter filter = this->filter(1);
  drive(filter, 20);
  EXPECT_LT(testing::distance(filter.best().pose, truth_), 0.03);
  EXPECT_NEAR(filter.best().pose.theta, truth_.theta, 0.02);
  EXPECT_EQ(filter.best_path().size(), 21u);
  EXPECT_LT(filter.spread()(0, 0), 0.01);
}

TEST_F(ParticleFilterTest, CallsTheParticleWithTheMostEvidenceTheBest) {
  for (const double threshold : {0.0, 0.5, 1.0}) {
    ParticleFilter filter = this->filter(1, threshold);
    for (int step = 1; step < 12; ++step) {
      drive(filter, 1);
      for (const Particle& particle : filter.particles()) {
        EXPECT_LE(particle.log_evidence, filter.best().log_evidence) << "step " << step << ", threshold " << threshold;
      }
    }
  }
}

TEST_F(ParticleFilterTest, GivesTheSameBitsWithAnyNumberOfThreads) {
  ParticleFilter one = filter(1, 0.9);
  drive(one, 10);
  for (const int threads : {2, 3, 64}) {
    ParticleFilter many = filter(threads, 0.9);
    drive(many, 10);
    for (std::size_t i = 0; i < one.particles().size(); ++i) {
      EXPECT_EQ(one.particles()[i].pose.vector(), many.particles()[i].pose.vector()) << threads;
      EXPECT_EQ(one.particles()[i].log_weight, many.particles()[i].log_weight) << threads;
    }
    EXPECT_EQ(one.effective_particles(), many.effective_particles());
  }
}

TEST_F(ParticleFilterTest, DrawsChildrenOfOneParentApart) {
  ParticleFilter filter = this->filter(1, 1.0);
  drive(filter, 3);
  for (std::size_t i = 1; i < filter.particles().size(); ++i) {
    EXPECT_NE(filter.particles()[0].pose.vector(), filter.particles()[i].pose.vector());
  }
}

TEST_F(ParticleFilterTest, ResamplesOnlyBelowTheThreshold) {
  ParticleFilter never = filter(1, 0.0);
  drive(never, 8);
  double low = 0.0, high = -1e9;
  for (const Particle& particle : never.particles()) {
    low = std::min(low, particle.log_weight);
    high = std::max(high, particle.log_weight);
  }
  EXPECT_LT(low, high) << "weights accumulate";

  ParticleFilter always = filter(1, 1.0);
  drive(always, 8);
  for (const Particle& particle : always.particles()) EXPECT_EQ(particle.log_weight, 0.0);
}

TEST_F(ParticleFilterTest, SharesMostOfTheMapBetweenParticlesAtTheStart) {
  const ParticleFilter filter = this->filter(1);
  const auto& tiles = filter.particles()[0].map.tiles();
  EXPECT_EQ(filter.particles()[5].map.tiles().count_shared(tiles), tiles.count());
}

TEST_F(ParticleFilterTest, DoesNotDrawAScanItIsToldNotToTrust) {
  ParticleFilter filter = this->filter(1);
  const auto shared = filter.particles()[0].map;
  MotionSinceUpdate motion;
  motion.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  filter.update(beams_at({}), motion, 0.1, false);
  EXPECT_EQ(filter.particles()[3].map.tiles().count_shared(shared.tiles()), shared.tiles().count());
}

TEST_F(ParticleFilterTest, ScattersAroundAPoseSetFromOutside) {
  ParticleFilter filter = this->filter(1);
  drive(filter, 3);
  filter.scatter({1.0, 1.0, 1.0}, Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal());
  EXPECT_EQ(filter.best().pose.x, 1.0);
  EXPECT_GT(filter.spread()(0, 0), 1e-4);
  EXPECT_EQ(filter.best_path().size(), 5u);
}

}  // namespace
}  // namespace slamfuse::laser_slam
