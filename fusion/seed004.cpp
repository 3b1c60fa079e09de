// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/seed004.hpp"

namespace slamfuse::fusion {

std::optional<Seed004Fit> fit_seed004(const std::vector<PosePair>&, const Seed004Options&, int, double) {
  return std::nullopt;
}

}  // namespace slamfuse::fusion
