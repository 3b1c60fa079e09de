// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/options.hpp"

namespace slamfuse::visual_slam {

using common::OptionVisitor;

void ConstantVelocityOptions::describe(OptionVisitor& visit) {
  visit.real("initial_speed_sigma", initial_speed_sigma, {0.0, 10.0}, "1/s", "How fast the robot may be at the start.");
  visit.real("initial_turn_rate_sigma", initial_turn_rate_sigma, {0.0, 360.0}, "deg/s", "How fast it may be turning.");
  visit.real("speed_noise", speed_noise, {0.0, 20.0}, "1/s/sqrt(s)", "How fast the speed changes.");
  visit.real("told_speed_noise", told_speed_noise, {0.0, 20.0}, "1/s/sqrt(s)",
             "How fast the speed changes while the floor tells it in metres.");
  visit.real("turn_rate_noise", turn_rate_noise, {0.0, 2000.0}, "deg/s/sqrt(s)", "How fast the turn rate changes.");
  visit.real("lateral_noise", lateral_noise, {0.0, 1.0}, "1/sqrt(1)", "How far the robot slips sideways.");
  visit.real(
      "lever_scale_sigma", lever_scale_sigma, {0.0, 2.0}, "",
      "Logarithm of how far the map's unit may be from a metre; turns tell, through the camera's lever arm. With "
      "one camera and floor_speed.enabled it is 0.");
  visit.real("unit_sigma", unit_sigma, {0.0, 0.5}, "",
             "Uncertainty of the map's unit that all lengths share and no measurement may reduce.");
}

void FreeCameraOptions::describe(OptionVisitor& visit) {
  visit.real("initial_speed_sigma", initial_speed_sigma, {0.0, 10.0}, "1/s",
             "How fast the camera may move along each axis at the start.");
  visit.real("initial_turn_rate_sigma", initial_turn_rate_sigma, {0.0, 360.0}, "deg/s",
             "How fast it may be turning about each axis.");
  visit.real("speed_noise", speed_noise, {0.0, 20.0}, "1/s/sqrt(s)", "How fast the velocity changes along each axis.");
  visit.real("turn_rate_noise", turn_rate_noise, {0.0, 2000.0}, "deg/s/sqrt(s)",
             "How fast the turn rate changes about each axis.");
  visit.real("lever_scale_sigma", lever_scale_sigma, {0.0, 2.0}, "",
             "Logarithm of how far the map's unit may be from a metre; turns tell, through the camera's lever arm.");
  visit.real("unit_sigma", unit_sigma, {0.0, 0.5}, "",
             "Uncertainty of the map's unit that all lengths share and no measurement may reduce.");
}

void TurnSearchOptions::describe(OptionVisitor& visit) {
  visit.real("max_turn", max_turn, {0.0, 90.0}, "deg", "Largest turn that is looked for.");
}

void FloorSpeedOptions::describe(OptionVisitor& visit) {
  visit.flag("enabled", enabled,
             "Whether motion.model constant_velocity with one camera reads its speed from the floor, in metres.");
  visit.real("max_speed", max_speed, {0.05, 2.5}, "m/s", "Largest speed that is looked for; backward a fifth of it.");
  visit.real("way_sigma", way_sigma, {0.0005, 0.1}, "m", "Standard deviation of the way between two pictures.");
  visit.integer("least_patches", least_patches, {1, 1000}, "",
                "Patches of floor that must tell a way. Fewer than 14 are never sure of it.");
  visit.real("scale_drift", scale_drift, {0.0, 1.0}, "1/sqrt(s)",
             "How the scale of what is seen drifts, as a standard deviation, while the floor tells metres.");
  visit.real("memory", memory, {0.0, 3600.0}, "s",
             "The map is in metres for so long after the floor was believed (0: never); then the landmarks say how "
             "fast the robot "
             "moves.");
  visit.real(
      "patience", patience, {0.1, 3600.0}, "s",
      "After so long in which what the floor says was refused again and again, what is seen is mapped anew. In "
      "the first so many seconds of a map that it has told nothing yet, after the second time: its unit is a guess.");
}

void MotionOptions::describe(OptionVisitor& visit) {
  visit.choice(
      "model", model,
      {{"odometry", MotionModelKind::kOdometry},
       {"constant_velocity", MotionModelKind::kConstantVelocity},
       {"free_camera", MotionModelKind::kFreeCamera}},
      "What says how the robot moves between images: the wheel odometry; constant speed and turn rate in the plane; or "
      "constant velocity and turn rate in space, for hand-held cameras and robots that pitch and roll. Without "
      "odometry "
      "the map has a scale of its own, unless one camera reads its speed from the floor (floor_speed).");
  visit.real("distance_noise", distance_noise, {0.0, 1.0}, "m/sqrt(m)",
             "Random error of the wheel odometry along the way, growing with the square root of the distance.");
  visit.real("lateral_noise", lateral_noise, {0.0, 1.0}, "m/sqrt(m)", "The same across the way.");
  visit.real("turn_noise_per_distance", turn_noise_per_distance, {0.0, 45.0}, "deg/sqrt(m)",
             "Random error of the heading from driving.");
  visit.real("turn_noise_per_turn", turn_noise_per_turn, {0.0, 90.0}, "deg/sqrt(360 deg)",
             "Random error of the heading from turning.");
  visit.real(
      "bearing_margin", bearing_margin, {1.0, 10.0}, "",
      "With one camera and wheel odometry bearings are taken for so many times as noisy as filter.pixel_sigma says, "
      "which makes room for what the linearisation of depths gets wrong.");
  visit.real("bearing_margin_of_several", bearing_margin_of_several, {1.0, 10.0}, "",
             "The same with several cameras, which tell depths at once.");
  visit.real("slip", slip, {0.0, 1.0}, "",
             "By which share of the way and of the turn the wheels slip when they slip (standard deviation); what the "
             "camera sees says when. 0: they never slip.");
  visit.flag(
      "calibrate", calibrate,
      "Estimate the systematic errors of the wheel odometry (scale of distance and of turn, turn per distance).");
  visit.real("distance_scale_sigma", distance_scale_sigma, {0.0, 0.5}, "",
             "How far the scale of the driven distance may be from 1. Only the odometry gives the map its scale, so "
             "this hardly gets better.");
  visit.real("turn_scale_sigma", turn_scale_sigma, {0.0, 0.5}, "", "How far the scale of the turns may be from 1.");
  visit.real("turn_per_distance_sigma", turn_per_distance_sigma, {0.0, 20.0}, "deg/m",
             "How far the wheel odometry may drift in heading on a straight way.");
  visit.nested("constant_velocity", constant_velocity, "The motion without wheel odometry; lengths in the map's unit.");
  visit.nested("free_camera", free_camera, "The motion of a free camera; lengths in the map's unit.");
}

void FrontEndOptions::describe(OptionVisitor& visit) {
  visit.choice(
      "kind", kind,
      {{"shi_tomasi_klt", FrontEndKind::kShiTomasiKlt}, {"sift", FrontEndKind::kSift}, {"orb", FrontEndKind::kOrb}},
      "Which features: Shi-Tomasi corners followed by pyramidal Lucas-Kanade, or SIFT or ORB features matched by their "
      "descriptors.");
  visit.integer("features_per_image", features_per_image, {8, 1000}, "", "Features wanted in each image.");
  visit.integer("grid_columns", grid_columns, {1, 64}, "", "Columns of the grid that spreads features over the image.");
  visit.integer("grid_rows", grid_rows, {1, 64}, "", "Rows of that grid.");
  visit.real("min_corner_strength", min_corner_strength, {0.0, 1.0}, "",
             "Smallest eigenvalue of the gradient matrix a corner needs (for gray values in 0..1).");
  visit.real("min_spacing", min_spacing, {2.0, 200.0}, "px", "Least distance between two features of an image.");
  visit.integer("window", window, {5, 61}, "px", "Side of the window that is followed from image to image.");
  visit.integer("pyramid_levels", pyramid_levels, {0, 6}, "", "Levels of the image pyramid above the image itself.");
  visit.real("max_backward_error", max_backward_error, {0.05, 20.0}, "px",
             "A feature followed forth and back must return this near.");
  visit.real("border", border, {0.0, 100.0}, "px", "Features this near to the image border are left alone.");
  visit.integer("keypoints_per_image", keypoints_per_image, {50, 10000}, "",
                "SIFT and ORB: keypoints at most, among which features are matched and chosen.");
  visit.choice("search", search, {{"complete", DescriptorSearch::kComplete}, {"flann", DescriptorSearch::kFlann}},
               "SIFT and ORB: how the nearest descriptors are searched, each with each or approximately by FLANN.");
  visit.real("match_ratio", match_ratio, {0.1, 1.0}, "",
             "SIFT and ORB: the nearest descriptor must be nearer than the second by this factor.");
  visit.real("search_radius", search_radius, {1.0, 2000.0}, "px",
             "SIFT and ORB: how far from the predicted pixel a feature is looked for.");
}

void SelectionOptions::describe(OptionVisitor& visit) {
  visit.choice("strategy", strategy,
               {{"none", SelectionStrategy::kNone},
                {"bottom_up", SelectionStrategy::kBottomUp},
                {"top_down", SelectionStrategy::kTopDown},
                {"both", SelectionStrategy::kBoth}},
               "Where new features are looked for: everywhere, where the picture stands out, on known objects, or on "
               "either of these.");
  visit.real("salient_share", salient_share, {0.0, 1.0}, "", "Share of a picture that is taken to stand out.");
  visit.integer("least_features", least_features, {0, 1000}, "",
                "When fewer features are followed than this, the rest of the picture makes up for them.");
  visit.text("objects", objects, "Folder of pictures of known flat objects, named as the objects.");
  visit.choice("object_features", object_features, {{"sift", FeatureKind::kSift}, {"orb", FeatureKind::kOrb}},
               "Features by which known objects are found.");
  visit.real("object_match_ratio", object_match_ratio, {0.1, 1.0}, "",
             "The nearest descriptor of an object must be nearer than the second by this factor.");
  visit.integer("object_matches", object_matches, {4, 1000}, "", "So many matches must agree on where an object is.");
}

void RecognitionOptions::describe(OptionVisitor& visit) {
  visit.flag("enabled", enabled, "Look for landmarks of the map that come back into view.");
  visit.integer("candidates_per_image", candidates_per_image, {0, 1000}, "", "At most so many are looked for.");
  visit.real("search_sigma", search_sigma, {1.0, 10.0}, "", "Search region in standard deviations of the prediction.");
  visit.real("max_search_radius", max_search_radius, {2.0, 400.0}, "px", "Largest search region around a prediction.");
  visit.real("min_correlation", min_correlation, {0.3, 1.0}, "",
             "Normalised correlation a patch needs to be taken for the landmark.");
  visit.real("max_scale_change", max_scale_change, {1.0, 4.0}, "",
             "A landmark is looked for only from distances within this factor of the one its patch was taken at.");
  visit.real("loop_absence", loop_absence, {0.5, 600.0}, "s",
             "Landmarks unseen for this long close a loop when they are found again.");
  visit.integer("loop_landmarks", loop_landmarks, {1, 1000}, "", "So many of them in one image make the event.");
}

void RelocalisationOptions::describe(OptionVisitor& visit) {
  visit.flag("enabled", enabled, "Search the whole map for the pose when it is lost, and for loops to close.");
  visit.choice("search", search, {{"complete", DescriptorSearch::kComplete}, {"flann", DescriptorSearch::kFlann}},
               "How the landmarks a feature looks like are searched: each with each, or approximately by FLANN.");
  visit.integer("features", features, {20, 2000}, "", "Features of an image that are looked up.");
  visit.integer("max_distance", max_distance, {1, 256}, "bits", "Descriptors that differ more are no match.");
  visit.real("ratio", ratio, {0.1, 1.0}, "", "The next landmark at another place must differ more by this factor.");
  visit.integer("hypotheses", hypotheses, {10, 100000}, "", "Poses through two matches that are tried an image.");
  visit.real("inlier_radius", inlier_radius, {0.5, 50.0}, "px",
             "A match this near to a pose's prediction agrees with it.");
  visit.integer("min_landmarks", min_landmarks, {3, 1000}, "", "So many different landmarks must agree...");
  visit.integer("min_images", min_images, {1, 100}, "", "...seen in so many images...");
  visit.real("clear_lead", clear_lead, {1.0, 100.0}, "", "...and so many times more than with any pose elsewhere.");
  visit.real("memory", memory, {0.0, 60.0}, "s", "Images as old as this still count...");
  visit.integer("max_images", max_images, {1, 1000}, "", "...and at most so many.");
}

void LoopOptions::describe(OptionVisitor& visit) {
  visit.flag("enabled", enabled, "Ask now and then whether an old part of the map is seen from elsewhere.");
  visit.real("interval", interval, {0.05, 60.0}, "s", "So often an image is looked at.");
  visit.real("min_age", min_age, {1.0, 3600.0}, "s", "Landmarks unseen for this long are an old part of the map.");
  visit.real(
      "min_drift", min_drift, {0.0, 100.0}, "m",
      "A pose off by less, and by less than the turn, is left to the search regions, which measure it better...");
  visit.real("min_turn_drift", min_turn_drift, {0.0, 180.0}, "deg", "...and this is the turn.");
  visit.real("max_drift", max_drift, {0.0, 1.0}, "", "Share of the way driven the pose may have drifted.");
  visit.real("max_turn_drift", max_turn_drift, {0.0, 180.0}, "deg", "The heading may have drifted so far.");
}

void FilterOptions::describe(OptionVisitor& visit) {
  visit.real("pixel_sigma", pixel_sigma, {0.05, 20.0}, "px", "Noise of a measured feature position.");
  visit.real("initial_inverse_depth", initial_inverse_depth, {0.001, 10.0}, "1/m",
             "Inverse depth a new landmark starts with (seed 002 section 2.3).");
  visit.real("inverse_depth_sigma", inverse_depth_sigma, {0.001, 10.0}, "1/m", "Its standard deviation.");
  visit.real(
      "scene_depth_sigma", scene_depth_sigma, {0.0, 10.0}, "",
      "With wheel odometry a new landmark starts with the median inverse depth of the landmarks of known depth in "
      "its image instead, where there are min_known_depths of them, with this relative standard deviation "
      "(0: never). It must be larger than known_depth.");
  visit.real("known_depth", known_depth, {0.0, 10.0}, "",
             "Relative uncertainty of the inverse depth above which parallax only teaches the landmark its depth.");
  visit.real("linearity_index", linearity_index, {0.0, 1.0}, "",
             "A landmark becomes Cartesian when its index of linearity falls below this, times motion.bearing_margin "
             "where there is one.");
  visit.choice("initialisation", initialisation,
               {{"inverse_depth", InitialisationKind::kInverseDepth},
                {"well_conditioned_pair", InitialisationKind::kWellConditionedPair}},
               "How a landmark enters: by inverse depth at first sight, or as a point once two sights of it fix its "
               "place. Without odometry and without a floor that tells metres the first landmarks always enter by "
               "inverse depth.");
  visit.real("max_divergence", max_divergence, {0.0001, 10.0}, "",
             "A pair of sights is well-conditioned when the Kullback-Leibler divergence of the landmark's distribution "
             "from a Gaussian is below this.");
  visit.integer("divergence_samples", divergence_samples, {2, 100000}, "",
                "Samples of the noise that divergence is computed from.");
  visit.real("gate_probability", gate_probability, {0.5, 0.99999}, "",
             "Share of right measurements the chi-square gate lets pass.");
  visit.integer(
      "iterations", iterations, {1, 10}, "",
      "Linearisations in an update (iterated Kalman filter). More than one make the filter overconfident: the "
      "Jacobians then know the noise of the measurements.");
  visit.integer(
      "min_known_depths", min_known_depths, {1, 1000}, "",
      "Without wheel odometry and floor, parallax of unknown depths teaches the motion, too, in images with fewer "
      "landmarks of known depth; with it, new landmarks start with initial_inverse_depth there.");
}

void MapOptions::describe(OptionVisitor& visit) {
  visit.integer("max_landmarks", max_landmarks, {10, 2000}, "", "Landmarks in the state at most.");
  visit.integer("max_archived", max_archived, {1, 100000}, "",
                "Landmarks that left the state and are kept for recognising places, at most.");
  visit.integer("max_keyframes", max_keyframes, {2, 2000}, "", "Past poses in the state at most.");
  visit.real("keyframe_distance", keyframe_distance, {0.01, 10.0}, "m", "A pose is kept after driving this far...");
  visit.real("keyframe_turn", keyframe_turn, {1.0, 180.0}, "deg", "...or turning this far.");
  visit.integer("max_failures", max_failures, {1, 100}, "",
                "A landmark is dropped when it failed so many times more often than it was found.");
}

void TrackingOptions::describe(OptionVisitor& visit) {
  visit.integer("min_inliers", min_inliers, {1, 100}, "", "Accepted features an image needs to count as tracked.");
  visit.real("uncertain_after", uncertain_after, {0.0, 60.0}, "s",
             "UNCERTAIN after this long without such an image; LOST when the images contradict the map.");
  visit.real("lost_after", lost_after, {0.1, 600.0}, "s", "LOST after this long without such an image.");
}

void ImageClockOptions::describe(OptionVisitor& visit) {
  visit.flag("correct", correct,
             "Whether stamps of pictures that disagree with the wheel odometry's are corrected, when the turns of the "
             "two clearly show by how much.");
  visit.real("most_offset", most_offset, {0.0, 5.0}, "s", "Offsets are looked for up to this.");
  visit.real("smallest_offset", smallest_offset, {0.001, 1.0}, "s",
             "A smaller offset is let be: the fusion finds what is left from the paths.");
  visit.real("most_sigma", most_sigma, {0.0001, 1.0}, "s",
             "An offset is believed only when its standard deviation is below this.");
  visit.real("memory", memory, {1.0, 3600.0}, "s", "Turns and odometry older than this are forgotten.");
  visit.real("kept_images", kept_images, {0.0, 10000.0}, "MB",
             "The latest images of all cameras, as many as fit into this, are kept until the stamps are known to be "
             "right; when they are not, the map is made anew from these images.");
}

void VisualSlamOptions::describe(OptionVisitor& visit) {
  visit.nested("motion", motion, "How the robot moves, and how far the wheel odometry is trusted.");
  visit.nested("image_clock", image_clock, "Whether the cameras' stamps fit the wheel odometry's.");
  visit.nested("front_end", front_end, "How features are found and followed.");
  visit.nested("selection", selection, "Which features are worth having.");
  visit.nested("floor_speed", floor_speed, "The speed without wheel odometry, from the floor's texture.");
  visit.nested("turn_search", turn_search, "Where features are looked for after a turn without wheel odometry.");
  visit.nested("recognition", recognition, "How lost landmarks are found again.");
  visit.nested("relocalisation", relocalisation, "How the pose is found in the whole map.");
  visit.nested("loop", loop, "How loops are closed whose drift is beyond the search regions.");
  visit.nested("filter", filter, "The extended Kalman filter.");
  visit.nested("map", map, "Which landmarks and poses stay in the state.");
  visit.nested("tracking", tracking, "When the estimate is called uncertain or lost.");
}

}  // namespace slamfuse::visual_slam
