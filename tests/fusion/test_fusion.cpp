// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/fusion.hpp"

#include <functional>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include "fusion/simulated_drive.hpp"
#include "fusion/uncertain_pose.hpp"

namespace slamfuse::fusion {
namespace {

using common::PoseSource;
using testing::HasSubstr;

constexpr int kLaserEvery = 4;
constexpr int kVisualEvery = 5;

/// What a run gave, with the truth beside each published pose.
struct DriveLog {
  std::vector<CorrectedPose> poses;
  std::vector<double> errors;  ///< [m], of each published pose
  std::vector<int> steps;
  std::vector<ModuleCommand> commands;
  std::vector<common::Event> events;
  std::vector<StatusEntry> status;

  double rmse(int from = 0, int to = std::numeric_limits<int>::max()) const {
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (steps[i] < from || steps[i] >= to) continue;
      sum += errors[i] * errors[i];
      ++count;
    }
    return count > 0 ? std::sqrt(sum / count) : std::numeric_limits<double>::infinity();
  }
  double worst(int from, int to) const {
    double error = 0.0;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (steps[i] >= from && steps[i] < to) error = std::max(error, errors[i]);
    }
    return error;
  }
  bool has_event(const std::string& kind) const {
    return std::any_of(events.begin(), events.end(), [&](const common::Event& event) { return event.kind == kind; });
  }
};

void append(DriveLog& run, const FusionOutput& output, const common::Pose2& truth, int step) {
  if (output.pose) {
    run.poses.push_back(*output.pose);
    run.steps.push_back(step);
    run.errors.push_back((output.pose->estimate.pose.translation() - truth.translation()).norm());
  }
  run.commands.insert(run.commands.end(), output.commands.begin(), output.commands.end());
  run.events.insert(run.events.end(), output.events.begin(), output.events.end());
  run.status.insert(run.status.end(), output.status.begin(), output.status.end());
}

/// Which messages a run gets, and how they are tampered with; returning false withholds one.
struct Scenario {
  bool with_odometry = true;
  int odometry_from = 0;  ///< step of its first message
  std::function<bool(int, common::PoseEstimate&)> laser = [](int, common::PoseEstimate&) { return true; };
  std::function<bool(int, common::PoseEstimate&)> visual = [](int, common::PoseEstimate&) { return true; };
};

bool silent(int, common::PoseEstimate&) { return false; }

DriveLog drive(Fusion& fusion, int steps, const Scenario& scenario) {
  SimulatedDrive simulation;
  DriveLog run;
  for (int step = 0; step < steps; ++step) {
    const common::Pose2 truth = simulation.truth(step);
    const common::WheelOdometry odometry = simulation.odometry(step);
    if (scenario.with_odometry && step >= scenario.odometry_from) append(run, fusion.process(odometry), truth, step);
    if (step % kLaserEvery == 0) {
      common::PoseEstimate laser = simulation.laser(step);
      if (scenario.laser(step, laser)) append(run, fusion.process(laser), truth, step);
    }
    if (step % kVisualEvery == 0) {
      common::PoseEstimate visual = simulation.visual(step);
      if (scenario.visual(step, visual)) append(run, fusion.process(visual), truth, step);
    }
  }
  return run;
}

std::unique_ptr<Fusion> make_fusion() { return *Fusion::create({}); }

TEST(Fusion, LaserAloneIsNotMadeWorse) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 1200, {.visual = silent});

  EXPECT_GE(run.poses.size(), 1200u);
  EXPECT_LT(run.rmse(), 0.035);  // the laser itself: 0.028
  EXPECT_EQ(fusion->map_frame(), PoseSource::kLaser);
  EXPECT_FALSE(run.has_event("raw_jump"));
}

TEST(Fusion, BothHalvesAreNoWorseThanTheBetterOne) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 1200, {});

  EXPECT_LT(run.rmse(), 0.035);
  ASSERT_TRUE(fusion->alignment().has_value());
  EXPECT_TRUE(fusion->alignment()->accepted) << fusion->alignment()->reason;
  EXPECT_TRUE(run.has_event("aligned"));
  EXPECT_NEAR(fusion->alignment()->rotation_deg, 40.0, 0.5);
  EXPECT_NEAR(fusion->alignment()->scale.x(), 2.0, 0.02);
}

TEST(Fusion, VisualAloneIsTheMapFrameAfterAMoment) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;

  const DriveLog run = drive(*fusion, 600, {.laser = silent});

  EXPECT_EQ(fusion->map_frame(), PoseSource::kVisual);
  ASSERT_GT(run.poses.size(), 500u);
  const Eigen::Vector2d visual = SimulatedDrive::laser_from_visual().inverse() * simulation.truth(599).translation();
  EXPECT_LT((run.poses.back().estimate.pose.translation() - visual).norm(), 0.15);
}

TEST(Fusion, WithoutOdometryThePoseFollowsTheLaser) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 1200, {.with_odometry = false, .visual = silent});

  ASSERT_EQ(run.poses.size(), 300u);
  EXPECT_LT(run.rmse(), 0.06);
  EXPECT_EQ(run.poses.back().T_map_odom.vector(), run.poses.back().estimate.pose.vector());
}

TEST(Fusion, OdometryThatStartsLateAndFarFromItsOriginMovesNothing) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 400, {.odometry_from = 42, .visual = silent});

  EXPECT_LT(run.worst(0, 400), 0.25);
  EXPECT_FALSE(run.has_event("raw_jump"));
}

TEST(Fusion, TheFinalPathHoldsWhereOdometryHadNotStartedYet) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  common::Trajectory2 laser_final;
  const auto exact = [&](int step, common::PoseEstimate& laser) {
    laser.pose = simulation.truth(step);
    laser_final.push_back({laser.stamp, laser.pose});
    return true;
  };
  const DriveLog run = drive(*fusion, 200, {.odometry_from = 42, .laser = exact, .visual = silent});

  const FusionResult result = fusion->finish(laser_final, {});

  ASSERT_EQ(result.fused_final.size(), run.poses.size());
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    const Eigen::Vector2d truth = simulation.truth(run.steps[i]).translation();
    EXPECT_LT((result.fused_final[i].pose.translation() - truth).norm(), 0.1) << "step " << run.steps[i];
  }
}

TEST(Fusion, AVisualPoseThatComesLateDoesNotMakeAFreshLaserPoseOld) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  drive(*fusion, 1200, {});  // aligned by now
  std::vector<common::PoseEstimate> waiting;
  DriveLog run;

  SimulatedDrive again;
  for (int step = 0; step < 1400; ++step) {
    const common::WheelOdometry odometry = again.odometry(step);
    const common::PoseEstimate laser = again.laser(step);
    const common::PoseEstimate visual = again.visual(step);
    if (step < 1200) continue;
    const common::Pose2 truth = again.truth(step);
    append(run, fusion->process(odometry), truth, step);
    if (step % kLaserEvery == 0) append(run, fusion->process(laser), truth, step);
    if (step % kVisualEvery != 0) continue;
    waiting.push_back(visual);
    if (waiting.size() <= 7) continue;  // 35 steps are 1.75 s
    append(run, fusion->process(waiting.front()), truth, step);
    waiting.erase(waiting.begin());
  }

  ASSERT_FALSE(run.poses.empty());
  for (const CorrectedPose& pose : run.poses) {
    EXPECT_EQ(pose.estimate.state, common::TrackingState::kTracking) << pose.estimate.stamp;
  }
}

TEST(Fusion, OneBadMeasurementNeverMakesAJump) {
  const auto fusion = make_fusion();
  const auto bad_once = [](int step, common::PoseEstimate& laser) {
    if (step == 400) laser.pose.x += 3.0;
    if (step == 600) laser.pose.theta += 1.0;
    return true;
  };

  const DriveLog run = drive(*fusion, 800, {.laser = bad_once, .visual = silent});

  EXPECT_LT(run.worst(390, 440), 0.1);
  EXPECT_LT(run.worst(590, 640), 0.1);
  EXPECT_FALSE(run.has_event("raw_jump"));
}

TEST(Fusion, ThePublishedPoseMovesSmoothlyWhenAPersistentJumpIsAdopted) {
  const auto fusion = make_fusion();
  const auto shifted = [](int step, common::PoseEstimate& laser) {
    if (step >= 400) laser.pose.x += 1.5;
    return true;
  };

  const DriveLog run = drive(*fusion, 800, {.laser = shifted, .visual = silent});

  EXPECT_TRUE(run.has_event("raw_jump"));
  for (std::size_t i = 1; i < run.poses.size(); ++i) {
    const double step =
        (run.poses[i].estimate.pose.translation() - run.poses[i - 1].estimate.pose.translation()).norm();
    EXPECT_LT(step, 0.12) << "step " << run.steps[i];  // 0.02 m driven, 0.05 m at once or 0.04 m of the transition
  }
  EXPECT_NEAR(run.worst(700, 800), 1.5, 0.1);  // it has arrived
}

TEST(Fusion, AJumpOfOneHalfIsOverruledByTheOtherAndTheHalfIsToldItsPose) {
  const auto fusion = make_fusion();
  const auto elsewhere = [](int step, common::PoseEstimate& laser) {
    if (step >= 800) laser.pose.x += 4.0;
    return true;
  };

  const DriveLog run = drive(*fusion, 1200, {.laser = elsewhere});

  EXPECT_LT(run.worst(800, 1200), 0.35);
  EXPECT_FALSE(run.has_event("raw_jump"));
  ASSERT_FALSE(run.commands.empty());
  EXPECT_EQ(run.commands.front().target, PoseSource::kLaser);
  EXPECT_LE(run.commands.size(), 5u);  // one in five seconds
  const bool suspect = std::any_of(run.status.begin(), run.status.end(), [](const StatusEntry& entry) {
    return entry.source == PoseSource::kLaser && entry.state == Verdict::kSuspect;
  });
  EXPECT_TRUE(suspect);
}

// A laser that has mapped another place follows that again after it was told its pose.
TEST(Fusion, AHalfThatWasOverruledIsNotUsedForAWhileAfterItWasToldItsPose) {
  constexpr int kWrong = 800;
  constexpr int kTold = 940;  // about
  const auto error_with = [](double probation) {
    FusionOptions options;
    options.supervision.probation = probation;
    const auto fusion = *Fusion::create(options);
    const auto laser = [](int step, common::PoseEstimate& estimate) {
      if (step >= kWrong) estimate.pose.x += step < kTold ? 4.0 : 0.1;
      return true;
    };
    const DriveLog run = drive(*fusion, 1020, {.laser = laser});
    EXPECT_FALSE(run.commands.empty());
    return run.rmse(kTold, 1020);
  };

  EXPECT_LT(error_with(6.0), 0.6 * error_with(0.0));
}

// What is lost may have mapped what was wrong: told its pose it is not used at once, as long as the other half tracks.
TEST(Fusion, AHalfThatWasLostIsNotUsedForAWhileAfterItWasToldItsPose) {
  const auto error_with = [](bool other_tracks) {
    const auto fusion = make_fusion();
    const auto laser = [](int step, common::PoseEstimate& estimate) {
      if (step >= 800 && step < 832) estimate.state = common::TrackingState::kLost;
      if (step >= 832) estimate.pose.x += 0.1;  // within the gate
      return true;
    };
    const auto visual = [other_tracks](int step, common::PoseEstimate& estimate) {
      if (!other_tracks && step >= 832) estimate.state = common::TrackingState::kUncertain;
      return true;
    };
    const DriveLog run = drive(*fusion, 920, {.laser = laser, .visual = visual});
    EXPECT_FALSE(run.commands.empty());
    return run.rmse(850, 920);
  };

  EXPECT_LT(error_with(true), 0.6 * error_with(false));
}

TEST(Fusion, OneHalfIsUsedWhereEachWasToldItsPoseByTheOther) {
  for (const bool with_odometry : {true, false}) {
    const auto fusion = make_fusion();
    const auto lost_from = [](int begin) {
      return [begin](int step, common::PoseEstimate& estimate) {
        if (step >= begin && step < begin + 32) estimate.state = common::TrackingState::kLost;
        return true;
      };
    };

    const DriveLog run =
        drive(*fusion, 980, {.with_odometry = with_odometry, .laser = lost_from(800), .visual = lost_from(840)});

    ASSERT_EQ(run.commands.size(), 2u);
    for (const StatusEntry& entry : run.status) {
      if (entry.source != PoseSource::kFused || common::to_seconds(entry.stamp - run.status[0].stamp) < 876 * 0.05) {
        continue;
      }
      EXPECT_EQ(entry.state, Verdict::kTracking) << with_odometry;
    }
    EXPECT_LT(run.rmse(876, 980), 0.06);
  }
}

// A map without a scale of its own bends: told another pose it would lose what holds it together.
/// Fed another place's scans a laser drifts away, slowly enough that no single pose is beyond the gate.
TEST(Fusion, ALaserThatDriftsAwayFromTheWheelsAndThePicturesIsNotFollowed) {
  const auto drifting = [](int step, common::PoseEstimate& laser) {
    if (step >= 1200) {
      laser.pose.x += 0.006 * (step - 1200);  // 12 cm a second
      laser.pose.theta += 0.003 * (step - 1200);
    }
    return true;
  };
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 1500, {.laser = drifting});

  EXPECT_LT(run.worst(1200, 1500), 0.15);
  const auto told = std::find_if(run.status.begin(), run.status.end(), [](const StatusEntry& entry) {
    return entry.source == PoseSource::kLaser && entry.state == Verdict::kSuspect;
  });
  ASSERT_NE(told, run.status.end());
  EXPECT_LT(common::to_seconds(told->stamp - run.status.front().stamp), 1200 * 0.05 + 2.0);
}

TEST(Fusion, AVisualHalfWithoutScaleIsNotToldItsPoseWhileItTracks) {
  const auto bent = [](int step, common::PoseEstimate& visual) {
    if (step >= 800) visual.pose.x += 2.0;
    return true;
  };
  const auto commands = [&bent](bool scale_drifts) {
    FusionOptions options;
    options.supervision.visual_scale_drifts = scale_drifts;
    const auto fusion = Fusion::create(options).value();
    return drive(*fusion, 1200, {.visual = bent}).commands.size();
  };
  EXPECT_GE(commands(false), 1u);
  EXPECT_EQ(commands(true), 0u);
}

/// The step at which a half that is lost from step 800 on is told its pose, one second later.
constexpr int kHelped = 820;

TEST(Fusion, TheVisualHalfCarriesOnWhereTheLaserIsLostAndTellsItThePose) {
  const auto fusion = make_fusion();
  const auto lost = [](int step, common::PoseEstimate& laser) {
    if (step >= 800) {
      laser.state = common::TrackingState::kLost;
      laser.pose = {50.0, 50.0, 0.0};
    }
    return true;
  };
  SimulatedDrive simulation;

  const DriveLog run = drive(*fusion, 1600, {.laser = lost});

  EXPECT_LT(run.worst(800, 1600), 0.25);
  EXPECT_EQ(run.steps.back(), 1599);
  ASSERT_FALSE(run.commands.empty());
  const auto& command = std::get<common::SetPose>(run.commands.front().command);
  EXPECT_LT((command.pose.translation() - simulation.truth(kHelped).translation()).norm(), 0.3);
}

// A carry, after which the camera knows the new place at once while the laser takes a moment to notice anything.
TEST(Fusion, AHalfThatWasLostAndFindsItselfElsewhereMakesThePoseLostAndThenGivesIt) {
  constexpr int kCarried = 800, kFound = 804, kNoticed = 812;
  const common::Pose2 there{6.0, 2.0, 0.0};
  const auto fusion = make_fusion();
  const auto visual = [&there](int step, common::PoseEstimate& estimate) {
    if (step >= kCarried && step < kFound) estimate.state = common::TrackingState::kLost;
    if (step >= kFound) {
      estimate.pose.x += there.x;
      estimate.pose.y += there.y;
    }
    return true;
  };
  const auto laser = [](int step, common::PoseEstimate& estimate) {
    if (step >= kNoticed) estimate.state = common::TrackingState::kLost;
    return true;
  };

  const DriveLog run = drive(*fusion, 900, {.laser = laser, .visual = visual});

  const bool lost = std::any_of(run.status.begin(), run.status.end(), [](const StatusEntry& entry) {
    return entry.source == PoseSource::kFused && entry.state == Verdict::kLost;
  });
  EXPECT_TRUE(lost);
  for (std::size_t i = 0; i < run.poses.size(); ++i) {
    if (run.steps[i] < kCarried + 2 || run.steps[i] > kNoticed) continue;
    EXPECT_NE(run.poses[i].estimate.state, common::TrackingState::kTracking) << run.steps[i];
  }
  EXPECT_EQ(run.poses.back().estimate.state, common::TrackingState::kTracking);
  EXPECT_GT(run.worst(860, 900), 4.0);  // at the place the visual half tells
}

TEST(Fusion, ALostVisualHalfIsToldItsPoseInItsOwnFrame) {
  const auto fusion = make_fusion();
  const auto lost = [](int step, common::PoseEstimate& visual) {
    if (step >= 800) visual.state = common::TrackingState::kLost;
    return true;
  };
  SimulatedDrive simulation;

  const DriveLog run = drive(*fusion, 900, {.visual = lost});

  ASSERT_FALSE(run.commands.empty());
  EXPECT_EQ(run.commands.front().target, PoseSource::kVisual);
  const auto& command = std::get<common::SetPose>(run.commands.front().command);
  const Eigen::Vector2d expected =
      SimulatedDrive::laser_from_visual().inverse() * simulation.truth(kHelped).translation();
  EXPECT_LT((command.pose.translation() - expected).norm(), 0.1);
}

TEST(Fusion, OdometryCarriesOnWhenBothHalvesAreSilentUntilItHasDriftedTooFar) {
  const auto fusion = make_fusion();
  const auto until_600 = [](int step, common::PoseEstimate&) { return step < 600; };

  const DriveLog run = drive(*fusion, 12000, {.laser = until_600, .visual = until_600});

  EXPECT_LT(run.worst(600, 800), 0.3);  // ten seconds, about four metres
  EXPECT_GT(run.steps.back(), 800);
  EXPECT_LT(run.steps.back(), 11999);
  EXPECT_TRUE(run.has_event("lost"));
  const auto& last = run.status.back();
  EXPECT_EQ(last.source, PoseSource::kFused);
  EXPECT_EQ(last.state, Verdict::kLost);
}

TEST(Fusion, AVisualMapThatBendsDoesNotDragAHealthyLaser) {
  const auto alone = make_fusion();
  const double laser_only = drive(*alone, 2400, {.visual = silent}).rmse();
  const auto bending = [](int step, common::PoseEstimate& visual) {
    visual.pose.x += 0.15 * std::sin(0.004 * step);  // up to 0.3 m in the laser's map
    visual.pose.y -= 0.10 * std::cos(0.003 * step);
    return true;
  };
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 2400, {.visual = bending});

  ASSERT_TRUE(fusion->alignment().has_value() && fusion->alignment()->accepted);
  EXPECT_LT(run.rmse(), 1.05 * laser_only);
}

TEST(Fusion, TheBendIsKnownWhenTheLaserFallsSilent) {
  const auto bending = [](int step, common::PoseEstimate& visual) {
    visual.pose.x += 0.15 * std::sin(0.0015 * step);  // up to 0.3 m in the laser's map
    return true;
  };
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 2000, {.laser = [](int step, auto&) { return step < 1800; }, .visual = bending});

  EXPECT_LT(run.worst(1800, 1830), 0.15);
  EXPECT_LT(run.rmse(1800, 2000), 0.15);  // ten seconds, four metres; a visual pose has 0.07 m of noise
  EXPECT_FALSE(run.has_event("raw_jump"));
}

/// The robot is carried by `kCarry` at step 800; both halves say they are lost, then one after the other finds itself.
constexpr int kCarried = 800;
constexpr int kLaserBack = 840;
const common::Pose2 kCarry{1.8, -2.5, 1.2};

DriveLog carried_drive(Fusion& fusion, const std::function<void(int, common::PoseEstimate&)>& visual_says) {
  const auto laser_says = [](int step, common::PoseEstimate& laser) {
    if (step < kCarried) return true;
    if (step < kLaserBack) {
      laser.state = common::TrackingState::kLost;
    } else {
      laser.pose = kCarry * laser.pose;
    }
    return true;
  };
  return drive(fusion, 1200, {.laser = laser_says, .visual = [&](int step, common::PoseEstimate& visual) {
                                if (step >= kCarried) visual_says(step, visual);
                                return true;
                              }});
}

/// Distance of the worst pose since `from` from where the robot was carried to, and steps on which there was none.
double worst_after_carry(const DriveLog& run, int from) {
  double worst = 0.0;
  SimulatedDrive simulation;
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    if (run.steps[i] < from) continue;
    const common::Pose2 truth = kCarry * simulation.truth(run.steps[i]);
    worst = std::max(worst, (run.poses[i].estimate.pose.translation() - truth.translation()).norm());
  }
  return worst;
}

TEST(Fusion, AfterACarryItIsLostAtOnceAndRightWithTheFirstPoseThatFoundItself) {
  const auto fusion = make_fusion();
  const auto stays_lost = [](int, common::PoseEstimate& visual) { visual.state = common::TrackingState::kLost; };

  const DriveLog run = carried_drive(*fusion, stays_lost);

  const int poses_while_lost = static_cast<int>(std::count_if(
      run.steps.begin(), run.steps.end(), [](int step) { return step >= kCarried + 15 && step < kLaserBack; }));
  EXPECT_EQ(poses_while_lost, 0) << "LOST has to be said within 0.75 s";
  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    if (run.steps[i] > kCarried && run.steps[i] < kLaserBack) {
      EXPECT_EQ(run.poses[i].estimate.state, common::TrackingState::kUncertain) << "step " << run.steps[i];
    }
  }
  EXPECT_LT(worst_after_carry(run, kLaserBack), 0.15);
  EXPECT_TRUE(run.has_event("lost"));
}

TEST(Fusion, AGuessDoesNotEndALostPose) {
  const auto fusion = make_fusion();
  const auto guesses = [](int step, common::PoseEstimate& visual) {
    visual.state = step < kCarried + 20 ? common::TrackingState::kLost : common::TrackingState::kUncertain;
  };

  const DriveLog run = carried_drive(*fusion, guesses);

  EXPECT_TRUE(std::none_of(run.steps.begin(), run.steps.end(),
                           [](int step) { return step >= kCarried + 15 && step < kLaserBack; }));
  EXPECT_LT(worst_after_carry(run, kLaserBack), 0.15);
}

TEST(Fusion, TheSameSilenceWithoutACarryIsNotLost) {
  const auto fusion = make_fusion();
  const auto three_seconds_of_silence = [](int step, common::PoseEstimate&) { return step < 800 || step >= 860; };

  const DriveLog run = drive(*fusion, 1200, {.laser = three_seconds_of_silence, .visual = three_seconds_of_silence});

  EXPECT_FALSE(run.has_event("lost"));
  EXPECT_LT(run.worst(800, 1200), 0.2);
}

TEST(Fusion, WaitsForALaserThatSearchesInsteadOfPublishingInAnotherFrame) {
  const auto fusion = make_fusion();
  const auto searching = [](int step, common::PoseEstimate& laser) {
    if (step < 100) laser.state = common::TrackingState::kLost;
    return true;
  };

  const DriveLog run = drive(*fusion, 300, {.laser = searching});

  ASSERT_FALSE(run.steps.empty());
  EXPECT_GE(run.steps.front(), 100);
  EXPECT_LT(run.worst(100, 300), 0.15);
  EXPECT_FALSE(run.has_event("frame_changed"));
}

TEST(Fusion, PosesThatArriveLateAreUsedAtTheirOwnStamps) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  std::vector<common::PoseEstimate> delayed;
  DriveLog run;
  for (int step = 0; step < 800; ++step) {
    append(run, fusion->process(simulation.odometry(step)), simulation.truth(step), step);
    if (step % kLaserEvery == 0) delayed.push_back(simulation.laser(step));
    if (!delayed.empty() && delayed.front().stamp <= simulation.stamp(step - 6)) {  // 0.3 s
      append(run, fusion->process(delayed.front()), simulation.truth(step), step);
      delayed.erase(delayed.begin());
    }
  }

  EXPECT_LT(run.rmse(), 0.05);  // 0.12 m if the poses were taken for those of their arrival
  for (std::size_t i = 1; i < run.poses.size(); ++i) {
    EXPECT_GT(run.poses[i].estimate.stamp, run.poses[i - 1].estimate.stamp);
  }
}

TEST(Fusion, AClockOffsetOfTheVisualHalfIsFoundToldAndUndone) {
  for (const double offset : {-0.3, 0.2}) {
    const auto fusion = make_fusion();
    const auto falsified = [&](int, common::PoseEstimate& visual) {
      visual.stamp += common::from_seconds(offset);
      return true;
    };

    const DriveLog run =
        drive(*fusion, 2000, {.laser = [](int step, auto&) { return step < 1700; }, .visual = falsified});

    ASSERT_TRUE(fusion->alignment().has_value());
    EXPECT_NEAR(fusion->alignment()->clock_offset, -offset, 0.03);
    EXPECT_TRUE(run.has_event("sensor_offsets"));
    EXPECT_LT(run.rmse(1720, 2000), 0.15) << "with the visual half alone";
    for (std::size_t i = 1; i < run.poses.size(); ++i) {
      ASSERT_GE(run.poses[i].estimate.stamp, run.poses[i - 1].estimate.stamp);
    }
  }
}

TEST(Fusion, OneHalfsDoubtMakesThePoseSuspectUntilTheOtherConfirmsIt) {
  const auto fusion = make_fusion();
  const auto doubts = [](int step, common::PoseEstimate& visual) {
    if (step >= 801) visual.state = common::TrackingState::kUncertain;
    return true;
  };

  const DriveLog run =
      drive(*fusion, 1000, {.laser = [](int step, auto&) { return step < 804 || step >= 812; }, .visual = doubts});

  for (std::size_t i = 0; i < run.steps.size(); ++i) {
    // The visual pose of step 805 doubts, the laser confirms, but counts only a second later.
    if (run.steps[i] < 600 || run.steps[i] == 805 || (run.steps[i] >= 824 && run.steps[i] <= 830)) continue;
    const bool suspect = run.poses[i].estimate.state == common::TrackingState::kUncertain;
    EXPECT_EQ(suspect, run.steps[i] > 805 && run.steps[i] < 824) << run.steps[i];
  }
}

TEST(Fusion, AHalfThatDoubtsItselfDoesNotTellALostOneWhereItIs) {
  const auto fusion = make_fusion();
  const auto lost = [](int step, common::PoseEstimate& laser) {
    if (step >= 800) laser.state = common::TrackingState::kLost;
    return true;
  };
  const auto uncertain = [](int step, common::PoseEstimate& visual) {
    if (step >= 800) visual.state = common::TrackingState::kUncertain;
    return true;
  };

  EXPECT_TRUE(drive(*fusion, 900, {.laser = lost, .visual = uncertain}).commands.empty());
}

TEST(Fusion, StampsThatStepBackAsInACarmenLogWorkWithTheLaserAlone) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  DriveLog run;
  for (int step = 0; step < 400; ++step) {
    common::WheelOdometry odometry = simulation.odometry(step);
    common::PoseEstimate laser = simulation.laser(step);
    if (step % 20 == 10) odometry.stamp = laser.stamp = simulation.stamp(step - 3) + 1;  // steps back by two
    append(run, fusion->process(odometry), simulation.truth(step), step);
    const FusionOutput output = fusion->process(laser);
    ASSERT_TRUE(output.pose.has_value());
    EXPECT_EQ(output.pose->estimate.stamp, laser.stamp);
    append(run, output, simulation.truth(step), step);
  }

  EXPECT_LT(run.rmse(), 0.04);
}

TEST(Fusion, RejectsPosesThatAreNotFiniteOrHaveNoCovariance) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  common::PoseEstimate bad_pose = simulation.laser(0);
  bad_pose.pose.x = std::numeric_limits<double>::quiet_NaN();
  common::PoseEstimate bad_covariance = simulation.laser(0);
  bad_covariance.covariance(1, 1) = -1.0;
  common::PoseEstimate wrong_source = simulation.laser(0);
  wrong_source.source = PoseSource::kFused;
  common::WheelOdometry bad_odometry = simulation.odometry(0);
  bad_odometry.pose.theta = std::numeric_limits<double>::infinity();

  EXPECT_THAT(fusion->process(bad_pose).rejected.value_or(""), HasSubstr("not finite"));
  EXPECT_THAT(fusion->process(bad_covariance).rejected.value_or(""), HasSubstr("variances"));
  EXPECT_THAT(fusion->process(wrong_source).rejected.value_or(""), HasSubstr("neither laser nor visual"));
  EXPECT_THAT(fusion->process(bad_odometry).rejected.value_or(""), HasSubstr("not finite"));
  EXPECT_FALSE(fusion->process(simulation.odometry(1)).pose.has_value());
}

TEST(Fusion, ANewMapEpochVoidsTheAlignmentAndOldEpochsAreRejected) {
  const auto fusion = make_fusion();
  drive(*fusion, 600, {});
  ASSERT_TRUE(fusion->alignment().has_value() && fusion->alignment()->accepted);
  SimulatedDrive simulation;
  common::PoseEstimate renewed = simulation.visual(600);
  renewed.map_epoch = 1;

  const FusionOutput output = fusion->process(renewed);

  EXPECT_FALSE(fusion->alignment().has_value());
  ASSERT_FALSE(output.events.empty());
  EXPECT_EQ(output.events.front().kind, "map_reset");
  EXPECT_THAT(fusion->process(simulation.visual(601)).rejected.value_or(""), HasSubstr("epoch 0"));
}

/// What was held against a half was so by the alignment, which is void.
TEST(Fusion, AHalfThatWasOverruledIsAlignedAnewAfterANewMapEpoch) {
  const auto elsewhere_then_anew = [](int step, common::PoseEstimate& visual) {
    if (step >= 800) visual.pose.x += 3.0;
    if (step >= 1000) visual.map_epoch = 1;
    return true;
  };
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 2400, {.visual = elsewhere_then_anew});

  ASSERT_TRUE(fusion->alignment().has_value());
  EXPECT_TRUE(fusion->alignment()->accepted) << fusion->alignment()->reason;
  const auto last = std::find_if(run.status.rbegin(), run.status.rend(),
                                 [](const StatusEntry& entry) { return entry.source == PoseSource::kVisual; });
  ASSERT_NE(last, run.status.rend());
  EXPECT_EQ(last->state, Verdict::kTracking);
}

/// The gaps of slow odometry are no pauses of all input.
TEST(Fusion, HalvesThatDieAreMissedThoughOdometryIsSlow) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  DriveLog run;
  for (int step = 0; step < 1200; ++step) {
    const common::Pose2 truth = simulation.truth(step);
    const common::WheelOdometry odometry = simulation.odometry(step);
    if (step % 10 == 0) append(run, fusion->process(odometry), truth, step);  // twice a second
    if (step % kLaserEvery == 0 && step < 600) append(run, fusion->process(simulation.laser(step)), truth, step);
  }

  EXPECT_EQ(run.status.back().source, PoseSource::kFused);
  EXPECT_NE(run.status.back().state, Verdict::kTracking);
}

TEST(Fusion, TwoHalvesWithoutOdometryAreNotMadeWorse) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 2400, {.with_odometry = false});

  EXPECT_LT(run.rmse(600), 0.06);  // the laser itself: 0.028
  EXPECT_FALSE(run.has_event("lost"));
}

TEST(Fusion, AlignsOnRequest) {
  const auto fusion = make_fusion();
  drive(*fusion, 60, {});
  ASSERT_FALSE(fusion->alignment().has_value());

  const FusionOutput output = fusion->align_now();

  ASSERT_EQ(output.events.size(), 1u);
  EXPECT_TRUE(fusion->alignment().has_value());
}

TEST(Fusion, StatusRowsComeOnceASecondAndWhenAStateChanges) {
  const auto fusion = make_fusion();

  const DriveLog run = drive(*fusion, 400, {});  // 20 s

  int fused_rows = 0;
  for (const StatusEntry& entry : run.status) {
    if (entry.source == PoseSource::kFused) ++fused_rows;
    EXPECT_GE(entry.score, 0.0);
    EXPECT_LE(entry.score, 1.0);
  }
  EXPECT_GE(fused_rows, 20);
  EXPECT_LE(fused_rows, 23);
}

TEST(Fusion, FinalPathIsAtLeastAsGoodAsTheLasers) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;
  common::Trajectory2 laser_final;
  common::Trajectory2 visual_final;
  const auto keep = [](common::Trajectory2& path) {
    return [&path](int, common::PoseEstimate& estimate) {
      path.push_back({estimate.stamp, estimate.pose});
      return true;
    };
  };
  const DriveLog run = drive(*fusion, 800, {.laser = keep(laser_final), .visual = keep(visual_final)});

  const FusionResult result = fusion->finish(laser_final, visual_final);

  EXPECT_TRUE(result.alignment.accepted) << result.alignment.reason;
  ASSERT_EQ(result.fused_final.size(), run.poses.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < result.fused_final.size(); ++i) {
    EXPECT_EQ(result.fused_final[i].stamp, run.poses[i].estimate.stamp);
    sum += (result.fused_final[i].pose.translation() - simulation.truth(run.steps[i]).translation()).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(result.fused_final.size())), 0.03);
}

TEST(Fusion, WhatIsKeptOfALongDriveIsBoundedAndStillAlignsIt) {
  constexpr std::size_t kMost = 2000;
  constexpr int kSteps = 40000;
  const auto fusion = *Fusion::create({}, kMost);
  SimulatedDrive simulation;
  common::ThinnedHistory<common::StampedPose2> laser(kMost);  // as the halves thin theirs
  common::ThinnedHistory<common::StampedPose2> visual(kMost / 3);
  const auto keep = [](auto& path) {
    return [&path](int, common::PoseEstimate& estimate) {
      path.push({estimate.stamp, estimate.pose});
      return true;
    };
  };
  const DriveLog run = drive(*fusion, kSteps, {.laser = keep(laser), .visual = keep(visual)});
  FusionOutput output = fusion->align_now();
  ASSERT_EQ(output.events.size(), 1u);
  EXPECT_EQ(output.events.front().kind, "aligned") << output.events.front().detail;

  const FusionResult result = fusion->finish(laser.items(), visual.items());

  EXPECT_TRUE(result.alignment.accepted) << result.alignment.reason;
  EXPECT_LE(result.fused_final.size(), kMost);
  EXPECT_GT(result.fused_final.size(), kMost / 3);
  EXPECT_LT(result.fused_final.front().stamp, simulation.stamp(kSteps / 10));
  EXPECT_EQ(result.fused_final.back().stamp, run.poses.back().estimate.stamp);
  double sum = 0.0;
  for (const auto& pose : result.fused_final) {
    const auto step = static_cast<int>((pose.stamp - simulation.stamp(0)) / SimulatedDrive::kStep);
    sum += (pose.pose.translation() - simulation.truth(step).translation()).squaredNorm();
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(result.fused_final.size())), 0.03);
}

TEST(Fusion, FinishingWithNothingGivesNothingAndAReason) {
  const auto fusion = make_fusion();

  const FusionResult result = fusion->finish({}, {});

  EXPECT_TRUE(result.fused_final.empty());
  EXPECT_FALSE(result.alignment.accepted);
  EXPECT_THAT(result.alignment.reason, HasSubstr("no laser trajectory"));
}

TEST(Fusion, GivesTheSamePosesEveryTime) {
  const auto first = make_fusion();
  const auto second = make_fusion();

  const DriveLog a = drive(*first, 600, {});
  const DriveLog b = drive(*second, 600, {});

  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].estimate.pose.vector(), b.poses[i].estimate.pose.vector());
    EXPECT_EQ(a.poses[i].estimate.covariance, b.poses[i].estimate.covariance);
  }
}

TEST(Fusion, TheCovarianceIsNotOverconfident) {
  const auto fusion = make_fusion();
  SimulatedDrive simulation;

  const DriveLog run = drive(*fusion, 1200, {});

  double sum = 0.0;
  for (std::size_t i = 0; i < run.poses.size(); ++i) {
    const Eigen::Vector3d error = difference(run.poses[i].estimate.pose, simulation.truth(run.steps[i]));
    sum += error.dot(run.poses[i].estimate.covariance.inverse() * error);
  }
  EXPECT_LT(sum / static_cast<double>(run.poses.size()), 3.0);  // normalised squared error, 3 when exact
}

TEST(FusionCreate, RefusesAnAngleStepThatDoesNotDivideARightAngle) {
  FusionOptions options;
  options.alignment.seed004.angle_step = 0.7;

  const auto fusion = Fusion::create(options);

  ASSERT_FALSE(fusion.has_value());
  EXPECT_EQ(fusion.error().kind, common::ErrorKind::kInvalidInput);
  EXPECT_THAT(fusion.error().message, HasSubstr("angle_step: 0.7"));
}

}  // namespace
}  // namespace slamfuse::fusion
