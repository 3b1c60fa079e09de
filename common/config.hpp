// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "common/error.hpp"
#include "common/options.hpp"

namespace slamfuse::common {

/// Visits every option a program knows, e.g. `[&](OptionVisitor& v) { v.nested("laser", laser, "..."); ... }`.
using DescribeOptions = std::function<void(OptionVisitor&)>;

/// Reads options from a YAML file. Keys that the file leaves out keep their value; nothing is changed on an error.
///
/// Strict (DESIGN section 2): an unknown key, a value of the wrong type or out of its range, NaN, a key given twice, an
/// empty document, a second document, anchors, broken YAML, a file larger than 256 KiB or nested deeper than 16 levels
/// is an error (kInvalidInput). All wrong keys of a file are told at once, a line each: `file:line:column`, the dotted
/// key, the value and what is allowed; for an unknown key the keys that are known there, nearest first.
Result<void> read_options(const std::filesystem::path& yaml, const DescribeOptions& describe);

/// Sets one option from text like "laser.particles=50", under the same rules; errors are of kind kUsage.
Result<void> set_option(std::string_view assignment, const DescribeOptions& describe);

/// All options as YAML with their present values, each under a comment with meaning, unit and range. read_options()
/// reads it back to exactly the same values.
std::string options_to_yaml(const DescribeOptions& describe);

/// All options as a Markdown table with dotted keys and present values, for the READMEs.
std::string options_to_markdown(const DescribeOptions& describe);

/// All options as lines of plain text, `key=value` and then meaning, unit and range, for `--help`.
std::string options_to_help(const DescribeOptions& describe);

}  // namespace slamfuse::common
