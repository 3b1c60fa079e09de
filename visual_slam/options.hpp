// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "common/options.hpp"

namespace slamfuse::visual_slam {

/// What says how the robot moves between images.
enum class MotionModelKind { kOdometry, kConstantVelocity, kFreeCamera };

/// The motion without wheel odometry. Lengths are in units of the map.
struct ConstantVelocityOptions {
  double initial_speed_sigma = 0.4;       ///< [1/s]
  double initial_turn_rate_sigma = 40.0;  ///< [deg/s]
  double speed_noise = 0.05;              ///< [1/s / sqrt(s)]
  double told_speed_noise = 0.3;          ///< [1/s / sqrt(s)]
  double turn_rate_noise = 80.0;          ///< [deg/s / sqrt(s)]
  double lateral_noise = 0.01;            ///< [1/sqrt(1)]
  double lever_scale_sigma = 0.5;
  double unit_sigma = 0.0;

  void describe(common::OptionVisitor& visit);
};

/// The motion of a free camera. Lengths are in units of the map.
struct FreeCameraOptions {
  double initial_speed_sigma = 0.4;       ///< [1/s], each axis
  double initial_turn_rate_sigma = 40.0;  ///< [deg/s], each axis
  double speed_noise = 0.2;               ///< [1/s / sqrt(s)], each axis
  double turn_rate_noise = 60.0;          ///< [deg/s / sqrt(s)], each axis
  double lever_scale_sigma = 0.5;
  double unit_sigma = 0.0;

  void describe(common::OptionVisitor& visit);
};

/// How far the robot may turn unforeseen between two images of a camera, without wheel odometry.
struct TurnSearchOptions {
  double max_turn = 17.0;  ///< [deg]

  void describe(common::OptionVisitor& visit);
};

/// How the floor is read for the speed, without wheel odometry.
struct FloorSpeedOptions {
  bool enabled = true;
  double max_speed = 1.25;   ///< [m/s]
  double way_sigma = 0.003;  ///< [m]
  int least_patches = 14;
  double scale_drift = 0.02;  ///< [1 / sqrt(s)]
  double memory = 10.0;       ///< [s]
  double patience = 3.0;      ///< [s]

  void describe(common::OptionVisitor& visit);
};

/// How far the wheel odometry is trusted. Standard deviations grow with the square root of the distance and of the
/// turn, as in seed 001 section 4.1 ((0.03 m)^2 / 1 m and (3 deg)^2 / 360 deg).
struct MotionOptions {
  MotionModelKind model = MotionModelKind::kOdometry;
  double distance_noise = 0.01;          ///< [m / sqrt(m)]
  double lateral_noise = 0.005;          ///< [m / sqrt(m)]
  double turn_noise_per_distance = 0.6;  ///< [deg / sqrt(m)]
  double turn_noise_per_turn = 3.0;      ///< [deg / sqrt(360 deg)]
  double bearing_margin = 1.25;
  double bearing_margin_of_several = 1.0;
  double slip = 0.2;
  bool calibrate = true;
  double distance_scale_sigma = 0.02;
  double turn_scale_sigma = 0.03;
  double turn_per_distance_sigma = 1.0;  ///< [deg / m]
  ConstantVelocityOptions constant_velocity;
  FreeCameraOptions free_camera;

  void describe(common::OptionVisitor& visit);
};

/// Which front end finds features and follows them.
enum class FrontEndKind { kShiTomasiKlt, kSift, kOrb };

/// Features that are known by a descriptor.
enum class FeatureKind { kSift, kOrb };

/// How the nearest descriptors are searched (seed 000 section II D).
enum class DescriptorSearch {
  kComplete,  ///< each with each: exact
  kFlann,     ///< approximate nearest neighbours: k-d trees for SIFT, locality-sensitive hashing for ORB
};

/// How features are found and followed in the pictures.
struct FrontEndOptions {
  FrontEndKind kind = FrontEndKind::kShiTomasiKlt;
  int features_per_image = 60;
  int grid_columns = 8;
  int grid_rows = 6;
  double min_corner_strength = 0.0005;
  double min_spacing = 14.0;  ///< [px]
  int window = 17;            ///< [px]
  int pyramid_levels = 3;
  double max_backward_error = 0.7;  ///< [px]
  double border = 8.0;              ///< [px]
  int keypoints_per_image = 1500;
  DescriptorSearch search = DescriptorSearch::kComplete;
  double match_ratio = 0.9;
  double search_radius = 40.0;  ///< [px]

  void describe(common::OptionVisitor& visit);
};

/// Where in the pictures new features are looked for (seed 001).
enum class SelectionStrategy {
  kNone,      ///< everywhere
  kBottomUp,  ///< where the picture stands out
  kTopDown,   ///< on known objects
  kBoth,
};

/// Which features are worth having (seed 001 section 2.2).
struct SelectionOptions {
  SelectionStrategy strategy = SelectionStrategy::kNone;
  double salient_share = 0.4;
  int least_features = 20;
  std::string objects;
  FeatureKind object_features = FeatureKind::kSift;
  double object_match_ratio = 0.75;
  int object_matches = 10;

  void describe(common::OptionVisitor& visit);
};

/// How lost landmarks of the map are found again.
struct RecognitionOptions {
  bool enabled = true;
  int candidates_per_image = 40;
  double search_sigma = 3.0;
  double max_search_radius = 60.0;  ///< [px]
  double min_correlation = 0.80;
  double max_scale_change = 1.7;
  double loop_absence = 5.0;  ///< [s]
  int loop_landmarks = 4;

  void describe(common::OptionVisitor& visit);
};

/// How the pose is found in the whole map.
struct RelocalisationOptions {
  bool enabled = true;
  DescriptorSearch search = DescriptorSearch::kComplete;
  int features = 250;
  int max_distance = 60;  ///< [bits of 256]
  double ratio = 0.85;
  int hypotheses = 600;
  double inlier_radius = 4.0;  ///< [px]
  int min_landmarks = 10;
  int min_images = 3;
  double clear_lead = 1.6;
  double memory = 3.0;  ///< [s]
  int max_images = 12;

  void describe(common::OptionVisitor& visit);
};

/// How loops are closed whose drift is beyond the filter's search regions.
struct LoopOptions {
  bool enabled = true;
  double interval = 0.5;        ///< [s]
  double min_age = 20.0;        ///< [s]
  double min_drift = 0.25;      ///< [m]
  double min_turn_drift = 6.0;  ///< [deg]
  double max_drift = 0.1;
  double max_turn_drift = 25.0;  ///< [deg]

  void describe(common::OptionVisitor& visit);
};

/// How a landmark enters the filter: by inverse depth when it is seen first (seed 002 section 2.3), or as a point once
/// two sights of it fix its place (seed 000 section II.E).
enum class InitialisationKind { kInverseDepth, kWellConditionedPair };

/// The extended Kalman filter.
struct FilterOptions {
  double pixel_sigma = 1.0;            ///< [px]
  double initial_inverse_depth = 0.4;  ///< [1/m]
  double inverse_depth_sigma = 0.4;    ///< [1/m]
  double scene_depth_sigma = 0.0;
  double known_depth = 0.2;
  double linearity_index = 0.10;
  InitialisationKind initialisation = InitialisationKind::kInverseDepth;
  double max_divergence = 0.2;
  int divergence_samples = 200;
  double gate_probability = 0.99;
  int iterations = 1;
  int min_known_depths = 6;

  void describe(common::OptionVisitor& visit);
};

/// Which landmarks and poses stay in the state.
struct MapOptions {
  int max_landmarks = 260;
  int max_archived = 3000;
  int max_keyframes = 120;
  double keyframe_distance = 0.5;  ///< [m]
  double keyframe_turn = 30.0;     ///< [deg]
  int max_failures = 3;

  void describe(common::OptionVisitor& visit);
};

/// When the estimate is called uncertain or lost.
struct TrackingOptions {
  int min_inliers = 8;
  double uncertain_after = 0.5;  ///< [s]
  double lost_after = 3.0;       ///< [s]

  void describe(common::OptionVisitor& visit);
};

/// How wrong stamps of a camera are looked for, see ImageClock.
struct ImageClockOptions {
  bool correct = true;
  double most_offset = 0.6;       ///< [s]
  double smallest_offset = 0.03;  ///< [s]
  double most_sigma = 0.008;      ///< [s]
  double memory = 60.0;           ///< [s]
  double kept_images = 64.0;      ///< [MB]

  void describe(common::OptionVisitor& visit);
};

/// Options of VisualSlam: the `visual:` section of the configuration.
struct VisualSlamOptions {
  MotionOptions motion;
  ImageClockOptions image_clock;
  FrontEndOptions front_end;
  SelectionOptions selection;
  TurnSearchOptions turn_search;
  FloorSpeedOptions floor_speed;
  RecognitionOptions recognition;
  RelocalisationOptions relocalisation;
  LoopOptions loop;
  FilterOptions filter;
  MapOptions map;
  TrackingOptions tracking;

  void describe(common::OptionVisitor& visit);
};

}  // namespace slamfuse::visual_slam
