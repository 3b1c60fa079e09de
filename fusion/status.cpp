// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/status.hpp"

namespace slamfuse::fusion {

std::string to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kTracking:
      return "TRACKING";
    case Verdict::kSuspect:
      return "SUSPECT";
    case Verdict::kLost:
      return "LOST";
  }
  return "UNKNOWN";
}

}  // namespace slamfuse::fusion
