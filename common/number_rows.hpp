// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// One line of a text file of numbers, with the place it stands for error messages.
struct NumberRow {
  std::string where;                          ///< "file:line"
  std::span<const std::string_view> columns;  ///< separated by blanks or tabs

  /// Column `index` as a finite number; the error names the place, the column and the text.
  Result<double> number(std::size_t index) const;
  /// Column `index` as a time, parsed digit by digit; the error names the place, the column and the text.
  Result<Nanoseconds> stamp(std::size_t index) const;
};

/// Reads a text file (plain, gzip, bzip2) line by line and hands every row to `take`, which may end the reading with an
/// error. Blank lines and lines that start with '#' are left out; line ends may be LF or CR LF. Errors (kInvalidInput):
/// the file cannot be read, has a line longer than LineReader::kLongestLine or no row at all, or what `take` returns.
Result<void> read_number_rows(const std::filesystem::path& path,
                              const std::function<Result<void>(const NumberRow&)>& take);

}  // namespace slamfuse::common
