// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "common/line_reader.hpp"
#include "common/time.hpp"

namespace slamfuse::common {

/// The columns a `data.csv` must have, the stamp first. Units and more behind a name ("x [m]") are left alone.
struct CsvColumns {
  std::vector<std::string> names;
  std::size_t required = 0;  ///< how many of them must be there
};

/// A row of a `data.csv`.
struct StampedRow {
  Nanoseconds stamp = 0;  ///< of the row; of a bad row that of the last good one, 0 without
  std::size_t line = 0;   ///< from 1
  std::string text;       ///< what follows the stamp and its comma
  std::string problem;    ///< empty, or why the row cannot be used: its stamp or its length
};

/// Reads an EuRoC/ASL `data.csv` row by row: stamps in integer nanoseconds, strictly rising. A row whose stamp is no
/// number, repeats or steps back is a bad row; so is one whose stamp runs more than a second ahead of the row behind it
/// while that one goes on from the row before (a single garbled stamp must not make all that follow step back).
class StampedCsv {
 public:
  /// Error (kInvalidInput): unreadable, no text, columns not as expected (by the "#" header; without one by the number
  /// of columns of the first row).
  static Result<StampedCsv> open(const std::filesystem::path& path, const CsvColumns& columns);

  /// The next row, good or bad; empty at the end. Error: the file became unreadable.
  Result<std::optional<StampedRow>> next();

  const std::filesystem::path& path() const { return path_; }

 private:
  struct RawRow {
    std::size_t line = 0;
    std::string text;
    std::optional<Nanoseconds> stamp;
    std::string problem;
  };

  StampedCsv(std::filesystem::path path, LineReader lines);
  Result<std::optional<RawRow>> read_raw_row();
  std::string stamp_problem(const RawRow& row) const;

  std::filesystem::path path_;
  LineReader lines_;
  std::optional<RawRow> ahead_;  ///< the row behind the one that next() returns
  std::optional<Nanoseconds> last_stamp_;
};

}  // namespace slamfuse::common
