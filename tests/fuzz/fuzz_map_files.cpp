// SPDX-License-Identifier: BSD-3-Clause
// The files of a map bundle, each without its checksum in the way, and Nav2 maps. The first byte chooses; a byte of 255
// separates a map's YAML from its image.
#include <algorithm>
#include <sstream>
#include <string>

#include "fuzz/scratch_file.hpp"
#include "service/grid_file.hpp"
#include "service/landmark_file.hpp"
#include "service/map_yaml.hpp"
#include "service/nav2_map.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace slamfuse;
  if (size == 0) return 0;
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  const std::size_t separator = std::min(text.find('\xff'), text.size());
  const std::string yaml = text.substr(0, separator);
  const std::string image = separator == text.size() ? std::string() : text.substr(separator + 1);
  switch (*data % 4) {
    case 0:
      static_cast<void>(service::parse_map_yaml(text));
      static_cast<void>(service::parse_map_yaml(service::sealed(text)));
      break;
    case 1:
      static_cast<void>(service::landmarks_from_bytes(text));
      break;
    case 2: {
      std::istringstream pgm(image);
      static_cast<void>(service::grid_from_files(pgm, yaml));
      break;
    }
    default: {
      fuzz::write_scratch("map.pgm", reinterpret_cast<const std::uint8_t*>(image.data()), image.size());
      const auto path =
          fuzz::write_scratch("nav2.yaml", reinterpret_cast<const std::uint8_t*>(yaml.data()), yaml.size());
      static_cast<void>(service::read_nav2_map(path));
    }
  }
  return 0;
}
