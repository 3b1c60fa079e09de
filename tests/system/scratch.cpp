// SPDX-License-Identifier: BSD-3-Clause
#include "system/scratch.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

namespace slamfuse::system {
namespace fs = std::filesystem;

namespace {

/// Keeps the rows of a data.csv up to a stamp.
void cut_csv(const fs::path& from, const fs::path& to, std::int64_t last_stamp) {
  std::vector<std::string> kept;
  for (const auto& line : read_lines(from)) {
    if (line.starts_with('#') || std::stoll(line) <= last_stamp) kept.push_back(line);
  }
  write_lines(to, kept);
}

}  // namespace

Scratch::Scratch() {
  std::string name = (fs::temp_directory_path() / "slamfuse-test-XXXXXX").string();
  path_ = ::mkdtemp(name.data());
}

Scratch::~Scratch() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path flat() { return fs::path(SLAMFUSE_DATA_DIR) / "flat"; }

void copy_beginning_of_flat(const fs::path& to, double seconds) {
  constexpr std::int64_t kStart = 1'700'000'000'000'000'000;
  const std::int64_t last = kStart + static_cast<std::int64_t>(seconds * 1e9);
  for (const auto& sensor : fs::directory_iterator(flat())) {
    if (!sensor.is_directory()) continue;
    const fs::path target = to / sensor.path().filename();
    fs::create_directories(target);
    if (fs::exists(sensor.path() / "sensor.yaml")) fs::copy(sensor.path() / "sensor.yaml", target / "sensor.yaml");
    cut_csv(sensor.path() / "data.csv", target / "data.csv", last);
    if (!fs::exists(sensor.path() / "data")) continue;
    fs::create_directories(target / "data");
    for (const auto& line : read_lines(target / "data.csv")) {
      if (line.starts_with('#')) continue;
      const std::string name = line.substr(line.find(',') + 1);
      fs::copy(sensor.path() / "data" / name, target / "data" / name);
    }
  }
}

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_text(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

std::vector<std::string> read_lines(const fs::path& path) {
  std::istringstream text(read_text(path));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

void write_lines(const fs::path& path, const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  write_text(path, text);
}

nlohmann::json read_json(const fs::path& path) { return nlohmann::json::parse(read_text(path)); }

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace slamfuse::system
