// SPDX-License-Identifier: BSD-3-Clause
#include "common/stamped_csv.hpp"

#include <cctype>
#include <string_view>
#include <utility>

#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

constexpr Nanoseconds kStampRunsAhead = kNanosecondsPerSecond;

bool names_column(std::string_view field, std::string_view name) {
  return field.starts_with(name) &&
         (field.size() == name.size() || std::isalnum(static_cast<unsigned char>(field[name.size()])) == 0);
}

std::string listed(const CsvColumns& columns) {
  std::string list;
  for (const std::string& name : columns.names) list += (list.empty() ? "" : ",") + name;
  return list;
}

Result<void> check_header(const std::string& where, std::string_view header, const CsvColumns& columns) {
  std::vector<std::string_view> fields;
  split_at_commas(header, fields);
  for (std::size_t i = 0; i < columns.names.size(); ++i) {
    if (i >= fields.size() && i >= columns.required) break;
    if (i >= fields.size() || !names_column(fields[i], columns.names[i])) {
      return invalid_input(where + ": column " + std::to_string(i + 1) + " is " +
                           (i < fields.size() ? in_quotes(fields[i]) : "missing") + " (expected: " + listed(columns) +
                           ")");
    }
  }
  return {};
}

Result<void> check_columns(const std::filesystem::path& path, const CsvColumns& columns) {
  Result<LineReader> lines = open_lines(path);
  if (!lines) return tl::unexpected(lines.error());
  while (true) {
    const Result<std::optional<LineReader::Line>> line = lines->next();
    if (!line) return tl::unexpected(line.error());
    if (!*line) return invalid_input(path.string() + ": empty (expected columns: " + listed(columns) + ")");
    const std::string_view text = (*line)->text;
    if (text.empty()) continue;
    const std::string where = path.string() + ":" + std::to_string((*line)->number);
    if (text.front() == '#') return check_header(where, text.substr(1), columns);
    std::vector<std::string_view> fields;
    split_at_commas(text, fields);
    if (fields.size() >= columns.required) return {};
    return invalid_input(where + ": " + std::to_string(fields.size()) + " columns (expected: " + listed(columns) + ")");
  }
}

}  // namespace

StampedCsv::StampedCsv(std::filesystem::path path, LineReader lines)
    : path_(std::move(path)), lines_(std::move(lines)) {}

Result<StampedCsv> StampedCsv::open(const std::filesystem::path& path, const CsvColumns& columns) {
  const Result<void> checked = check_columns(path, columns);
  if (!checked) return tl::unexpected(checked.error());
  Result<LineReader> lines = open_lines(path);
  if (!lines) return tl::unexpected(lines.error());
  StampedCsv csv(path, std::move(*lines));
  Result<std::optional<RawRow>> first = csv.read_raw_row();
  if (!first) return tl::unexpected(first.error());
  csv.ahead_ = std::move(*first);
  return csv;
}

Result<std::optional<StampedCsv::RawRow>> StampedCsv::read_raw_row() {
  while (true) {
    const Result<std::optional<LineReader::Line>> line = lines_.next();
    if (!line) return tl::unexpected(line.error());
    if (!*line) return std::nullopt;
    const std::string_view text = (*line)->text;
    if (text.empty() || text.front() == '#') continue;
    RawRow row;
    row.line = (*line)->number;
    if ((*line)->too_long) {
      row.problem = "line longer than " + std::to_string(LineReader::kLongestLine) + " characters";
      return row;
    }
    const std::size_t comma = text.find(',');
    const std::string_view stamp = text.substr(0, comma);
    row.stamp = parse_integer(stamp);
    if (!row.stamp || *row.stamp < 0 || *row.stamp > kLatestStamp) {
      row.stamp.reset();
      row.problem =
          "stamp " + in_quotes(stamp) + " (allowed: nanoseconds from 0 to " + std::to_string(kLatestStamp) + ")";
    }
    if (comma != std::string_view::npos) row.text = text.substr(comma + 1);
    return row;
  }
}

std::string StampedCsv::stamp_problem(const RawRow& row) const {
  const std::string stamp = "stamp " + std::to_string(*row.stamp);
  if (last_stamp_ && *row.stamp == *last_stamp_) return stamp + " repeats (allowed: rising stamps)";
  if (last_stamp_ && *row.stamp < *last_stamp_) {
    return stamp + " steps back behind " + std::to_string(*last_stamp_) + " (allowed: rising stamps)";
  }
  if (ahead_ && ahead_->stamp && *row.stamp - *ahead_->stamp > kStampRunsAhead &&
      (!last_stamp_ || *ahead_->stamp > *last_stamp_)) {
    return stamp + " runs ahead of the next row's " + std::to_string(*ahead_->stamp) + " (allowed: rising stamps)";
  }
  return {};
}

Result<std::optional<StampedRow>> StampedCsv::next() {
  if (!ahead_) return std::nullopt;
  RawRow row = std::move(*ahead_);
  Result<std::optional<RawRow>> following = read_raw_row();
  if (!following) return tl::unexpected(following.error());
  ahead_ = std::move(*following);

  if (row.problem.empty()) row.problem = stamp_problem(row);
  if (row.problem.empty()) last_stamp_ = *row.stamp;
  return StampedRow{last_stamp_.value_or(0), row.line, std::move(row.text), std::move(row.problem)};
}

}  // namespace slamfuse::common
