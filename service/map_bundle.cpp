// SPDX-License-Identifier: BSD-3-Clause
#include "service/map_bundle.hpp"

#include <array>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "common/tum.hpp"
#include "service/bounded_file.hpp"
#include "service/checksum.hpp"
#include "service/colmap_model.hpp"
#include "service/durable_file.hpp"
#include "service/grid_file.hpp"
#include "service/landmark_file.hpp"
#include "service/landmark_ply.hpp"
#include "service/map_yaml.hpp"

namespace slamfuse::service {
namespace {

namespace fs = std::filesystem;

/// map.yaml holds a few kilobytes; more is not ours.
constexpr std::uintmax_t kMaxMapYamlBytes = std::uintmax_t{1} << 20;

/// Writes the files of a bundle one after the other and keeps the list of them.
class BundleWriter {
 public:
  explicit BundleWriter(fs::path folder) : folder_(std::move(folder)) {}

  /// Writes what `produce(take)` hands to `take`, piece by piece. After an error nothing more is written.
  template <class Produce>
  void write_pieces(const std::string& name, const Produce& produce) {
    if (!done_) return;
    auto file = DurableFile::create(folder_ / name);
    if (!file) {
      done_ = tl::unexpected(file.error());
      return;
    }
    MapBundleFile entry{name, 0, 0};
    produce([&](std::string_view piece) {
      entry.bytes += piece.size();
      entry.crc32 = crc32_of(piece, entry.crc32);
      if (done_) done_ = file->append(piece);
    });
    if (done_) done_ = file->publish();
    files_.push_back(std::move(entry));
  }
  void write(const std::string& name, std::string_view content) {
    write_pieces(name, [&](const auto& take) { take(content); });
  }

  const std::vector<MapBundleFile>& files() const { return files_; }
  const common::Result<void>& done() const { return done_; }

 private:
  fs::path folder_;
  std::vector<MapBundleFile> files_;
  common::Result<void> done_;
};

common::Result<void> write_colmap_model(const MapBundle& bundle, const fs::path& folder, BundleWriter& writer) {
  std::error_code error;
  if (!fs::create_directory(folder / kColmapFolder, error)) {
    return common::failed(fmt::format("cannot write {}: {}", (folder / kColmapFolder).string(), error.message()));
  }
  const ColmapModel model = colmap_model(bundle.cameras, bundle.keyframes, bundle.landmarks);
  writer.write(kColmapCameras, model.cameras);
  writer.write(kColmapImages, model.images);
  writer.write(kColmapPoints, model.points);
  return sync_folder(folder / kColmapFolder);
}

common::Result<void> write_contents(const MapBundle& bundle, const fs::path& folder) {
  BundleWriter writer(folder);
  if (bundle.grid && bundle.grid->width > 0) {
    writer.write_pieces(kGridImage, [&](const auto& take) { grid_to_pgm(*bundle.grid, take); });
    writer.write(kGridYaml, grid_to_yaml(*bundle.grid, kGridImage));
  }
  if (!bundle.laser_state.empty()) writer.write(kLaserState, bundle.laser_state);
  if (!bundle.landmarks.empty()) {
    writer.write(kLandmarks, landmarks_to_bytes(bundle.landmarks));
    writer.write(kLandmarksPly, landmarks_to_ply(bundle.landmarks, bundle.alignment.value_or(fusion::Alignment{})));
    if (!bundle.keyframes.empty()) {
      if (auto written = write_colmap_model(bundle, folder, writer); !written) return written;
    }
  }
  for (const auto& [name, trajectory] : bundle.trajectories) writer.write(name + ".tum", common::to_tum(trajectory));
  writer.write(kMapYaml, map_yaml_of(bundle, writer.files()));
  return writer.done() ? sync_folder(folder) : writer.done();
}

/// Compares a file with what map.yaml says of it, without holding it.
common::Result<void> check(const fs::path& folder, const MapBundleFile& entry) {
  const fs::path path = folder / entry.name;
  std::ifstream file;
  const auto size = open_bounded(path, kMaxMapFileBytes, file);
  if (!size) return tl::unexpected(size.error());
  if (*size != entry.bytes) {
    return common::invalid_input(
        fmt::format("{}: {} bytes, map.yaml says {}: cut or replaced", path.string(), *size, entry.bytes));
  }
  std::vector<char> piece(std::size_t{1} << 16);
  std::uint32_t crc32 = 0;
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0) {
    crc32 = crc32_of({piece.data(), static_cast<std::size_t>(file.gcount())}, crc32);
  }
  if (crc32 != entry.crc32) {
    return common::invalid_input(fmt::format("{}: checksum {:08x}, map.yaml says {:08x}: the file was altered",
                                             path.string(), crc32, entry.crc32));
  }
  return {};
}

common::Result<void> read_grid(const fs::path& folder, LoadedMapBundle& bundle) {
  if (!has_file(bundle.summary.files, kGridYaml)) return {};
  const auto yaml = read_bounded(folder / kGridYaml, kMaxMapYamlBytes);
  if (!yaml) return tl::unexpected(yaml.error());
  std::ifstream image(folder / kGridImage, std::ios::binary);
  auto grid = grid_from_files(image, *yaml);
  if (!grid) return common::invalid_input(folder.string() + ": " + grid.error().message);
  bundle.grid = std::move(*grid);
  return {};
}

common::Result<void> read_landmarks(const fs::path& folder, LoadedMapBundle& bundle) {
  const auto bytes = read_bounded(folder / kLandmarks, kMaxMapFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  auto landmarks = landmarks_from_bytes(*bytes);
  if (!landmarks) return common::invalid_input(folder.string() + ": " + landmarks.error().message);
  bundle.landmarks = std::move(*landmarks);
  return {};
}

common::Result<void> read_laser_state(const fs::path& folder, LoadedMapBundle& bundle) {
  auto bytes = read_bounded(folder / kLaserState, kMaxMapFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  bundle.laser_state = std::move(*bytes);
  return {};
}

}  // namespace

common::Result<void> write_map_bundle(const MapBundle& bundle, const fs::path& path) {
  const fs::path temporary = path.string() + ".partial";
  std::error_code error;
  fs::remove_all(temporary, error);
  if (!fs::create_directories(temporary, error)) {
    return common::failed(fmt::format("cannot write {}: {}", path.string(), error.message()));
  }
  auto done = write_contents(bundle, temporary);
  if (done) done = replace_path(temporary, path);
  if (!done) fs::remove_all(temporary, error);
  return done;
}

bool is_map_bundle(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path / kMapYaml, error);
}

std::vector<std::string> files_of_map_bundle(const fs::path& path) {
  const auto yaml = read_bounded(path / kMapYaml, kMaxMapYamlBytes);
  const auto summary = yaml ? parse_map_yaml(*yaml) : tl::unexpected(yaml.error());
  if (!summary) return {};
  std::vector<std::string> names{kMapYaml};
  for (const auto& file : summary->files) names.push_back(file.name);
  return names;
}

common::Result<LoadedMapBundle> read_map_bundle(const fs::path& path) {
  const auto yaml = read_bounded(path / kMapYaml, kMaxMapYamlBytes);
  if (!yaml) return tl::unexpected(yaml.error());
  auto summary = parse_map_yaml(*yaml);
  if (!summary) return common::invalid_input(path.string() + "/" + summary.error().message);

  LoadedMapBundle bundle;
  bundle.summary = std::move(*summary);
  for (const auto& file : bundle.summary.files) {
    if (auto good = check(path, file); !good) return tl::unexpected(good.error());
  }
  const std::array<std::pair<const char*, common::Result<void> (*)(const fs::path&, LoadedMapBundle&)>, 3> readers{
      {{kGridImage, read_grid}, {kLaserState, read_laser_state}, {kLandmarks, read_landmarks}}};
  for (const auto& [name, read] : readers) {
    if (!has_file(bundle.summary.files, name)) continue;
    if (auto done = read(path, bundle); !done) return tl::unexpected(done.error());
  }
  return bundle;
}

}  // namespace slamfuse::service
