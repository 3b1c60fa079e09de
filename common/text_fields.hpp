// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace slamfuse::common {

/// Splits a line at every comma; blanks around a field are dropped, empty fields stay. The views point into `line`.
/// `fields` is overwritten (passed in so that its memory is used again for the next line).
void split_at_commas(std::string_view line, std::vector<std::string_view>& fields);

/// Splits a line at runs of blanks and tabs. The views point into `line`; `fields` is overwritten.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& fields);

/// A finite decimal number that fills the whole text, else nothing ("nan", "inf", "1.5x" and "" are nothing).
std::optional<double> parse_real(std::string_view text);

/// A decimal integer that fills the whole text and fits, else nothing.
std::optional<std::int64_t> parse_integer(std::string_view text);

/// Text from a file made fit for an error message: at most 40 characters, in quotes, unprintable bytes as '?'.
std::string in_quotes(std::string_view text);

}  // namespace slamfuse::common
