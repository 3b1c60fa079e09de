// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "fusion/alignment_keeper.hpp"
#include "fusion/alignment_options.hpp"
#include "fusion/corrected_pose_filter.hpp"
#include "fusion/correction_limiter.hpp"
#include "fusion/measurement_model.hpp"
#include "fusion/motion_check.hpp"
#include "fusion/source_monitor.hpp"
#include "fusion/supervision_options.hpp"

namespace slamfuse::fusion {

/// The YAML section `fusion:`.
struct FusionOptions {
  AlignmentOptions alignment;
  AlignmentScheduleOptions schedule;
  CorrectedPoseOptions filter;
  CorrectionLimitOptions limit;
  MeasurementOptions measurement;
  MotionCheckOptions motion;
  SourceMonitorOptions monitor;
  SupervisionOptions supervision;

  void describe(common::OptionVisitor& visit) {
    visit.nested("alignment", alignment, "Alignment of the two trajectories.");
    visit.nested("schedule", schedule, "When the alignment is tried.");
    visit.nested("filter", filter, "The corrected pose.");
    visit.nested("limit", limit, "How fast the published correction may move.");
    visit.nested("measurement", measurement, "How far a half's own covariance is believed.");
    visit.nested("motion", motion, "Comparing each half's motion with the wheels'.");
    visit.nested("monitor", monitor, "Judging the halves.");
    visit.nested("supervision", supervision, "Withholding the pose, commands to the halves, status rows.");
  }
};

}  // namespace slamfuse::fusion
