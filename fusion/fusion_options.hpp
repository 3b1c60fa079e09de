// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "common/options.hpp"
#include "fusion/alignment_options.hpp"

namespace slamfuse::fusion {

/// The YAML section `fusion:`.
struct FusionOptions {
  AlignmentOptions alignment;

  void describe(common::OptionVisitor& visit) {
    visit.nested("alignment", alignment, "Alignment of the two trajectories.");
  }
};

}  // namespace slamfuse::fusion
