// SPDX-License-Identifier: BSD-3-Clause
#include "common/number_text.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <vector>

#include <fmt/format.h>

#include "common/quote.hpp"

namespace slamfuse::common {
namespace {

constexpr std::string_view kBlanks = " \t\r";

/// The parts of a line between blanks, as views into it.
void split(std::string_view line, std::vector<std::string_view>& columns) {
  columns.clear();
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    columns.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
}

}  // namespace

std::optional<double> parse_finite(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

Result<double> NumberRow::number(std::size_t index) const {
  const std::optional<double> value = parse_finite(columns[index]);
  if (value) return *value;
  return invalid_input(
      fmt::format("{}: column {} is {}, expected a finite number", where, index + 1, quote(columns[index])));
}

Result<Nanoseconds> NumberRow::stamp(std::size_t index) const {
  const std::optional<Nanoseconds> value = parse_decimal_seconds(columns[index]);
  if (value) return *value;
  return invalid_input(
      fmt::format("{}: column {} is {}, expected a time in decimal seconds", where, index + 1, quote(columns[index])));
}

Result<void> read_number_rows(const std::filesystem::path& path,
                              const std::function<Result<void>(const NumberRow&)>& take) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return invalid_input(fmt::format("{}: is a folder, expected a text file", path.string()));
  }
  errno = 0;
  std::ifstream file(path);
  if (!file) return invalid_input(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));

  std::string line;
  std::vector<std::string_view> columns;
  bool any = false;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    split(line, columns);
    if (columns.empty() || columns.front().front() == '#') continue;
    any = true;
    if (Result<void> taken = take({fmt::format("{}:{}", path.string(), number), columns}); !taken) return taken;
  }
  if (file.bad()) return invalid_input(fmt::format("{}: reading failed: {}", path.string(), std::strerror(errno)));
  if (!any) return invalid_input(fmt::format("{}: has no line of numbers", path.string()));
  return {};
}

}  // namespace slamfuse::common
