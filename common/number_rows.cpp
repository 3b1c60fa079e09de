// SPDX-License-Identifier: BSD-3-Clause
#include "common/number_rows.hpp"

#include <optional>
#include <vector>

#include <fmt/format.h>

#include "common/line_reader.hpp"
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
  Result<LineReader> lines = open_lines(path);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<std::string_view> columns;
  bool any = false;
  while (true) {
    const Result<std::optional<LineReader::Line>> line = lines->next();
    if (!line) return tl::unexpected(line.error());
    if (!*line) break;
    const std::string where = fmt::format("{}:{}", path.string(), (*line)->number);
    if ((*line)->too_long) {
      return invalid_input(fmt::format("{}: line longer than {} characters", where, LineReader::kLongestLine));
    }
    split_at_blanks((*line)->text, columns);
    if (columns.empty() || columns.front().front() == '#') continue;
    any = true;
    if (Result<void> taken = take({where, columns}); !taken) return taken;
  }
  if (!any) return invalid_input(fmt::format("{}: has no line of numbers", path.string()));
  return {};
}

}  // namespace slamfuse::common
