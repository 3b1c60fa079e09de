// SPDX-License-Identifier: BSD-3-Clause
#include "fusion/alignment_options.hpp"

namespace slamfuse::fusion {

std::string to_string(AlignmentMethod method) {
  switch (method) {
    case AlignmentMethod::kSeed004:
      return "seed004";
    case AlignmentMethod::kRigid:
      return "rigid";
    case AlignmentMethod::kSimilarity:
      return "similarity";
    case AlignmentMethod::kAffine:
      return "affine";
    case AlignmentMethod::kAuto:
      return "auto";
  }
  return "unknown";
}

}  // namespace slamfuse::fusion
