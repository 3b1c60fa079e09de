// SPDX-License-Identifier: BSD-3-Clause
#include "common/number_rows.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "common/text_fields.hpp"

namespace slamfuse::common {
Result<double> NumberRow::number(std::size_t index) const {
  const std::optional<double> value = parse_real(columns[index]);
  if (value) return *value;
  return invalid_input(
      fmt::format("{}: column {} is {}, expected a finite number", where, index + 1, in_quotes(columns[index])));
}

Result<Nanoseconds> NumberRow::stamp(std::size_t index) const {
  const std::optional<Nanoseconds> value = parse_decimal_seconds(columns[index]);
  if (value) return *value;
  return invalid_input(fmt::format("{}: column {} is {}, expected a time in decimal seconds", where, index + 1,
                                   in_quotes(columns[index])));
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
    if (line.ends_with('\r')) line.pop_back();
    split_at_blanks(line, columns);
    if (columns.empty() || columns.front().front() == '#') continue;
    any = true;
    if (Result<void> taken = take({fmt::format("{}:{}", path.string(), number), columns}); !taken) return taken;
  }
  if (file.bad()) return invalid_input(fmt::format("{}: reading failed: {}", path.string(), std::strerror(errno)));
  if (!any) return invalid_input(fmt::format("{}: has no line of numbers", path.string()));
  return {};
}

}  // namespace slamfuse::common
