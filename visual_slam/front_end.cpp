// SPDX-License-Identifier: BSD-3-Clause
#include "visual_slam/front_end.hpp"

#include "visual_slam/descriptor_front_end.hpp"
#include "visual_slam/klt_front_end.hpp"

namespace slamfuse::visual_slam {

std::unique_ptr<FrontEnd> make_front_end(const FrontEndOptions& options, std::size_t cameras) {
  switch (options.kind) {
    case FrontEndKind::kShiTomasiKlt:
      break;
    case FrontEndKind::kSift:
      return std::make_unique<DescriptorFrontEnd>(options, FeatureKind::kSift, cameras);
    case FrontEndKind::kOrb:
      return std::make_unique<DescriptorFrontEnd>(options, FeatureKind::kOrb, cameras);
  }
  return std::make_unique<KltFrontEnd>(options, cameras);
}

}  // namespace slamfuse::visual_slam
