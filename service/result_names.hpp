// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/error.hpp"

namespace slamfuse::service {

/// Which command's results an output folder holds.
enum class ResultKind { kRun, kAlignment };

/// Everything the command may write: what a new run of it replaces or removes in its output folder.
const std::vector<std::string>& result_names(ResultKind kind);

/// Makes sure that results of this kind can take the place of what is in the folder without loss of anything but
/// results of the same kind. Errors (kInvalidInput) name what is in the way: a result of the other command, a
/// trajectory that slamfuse has not written, a folder with the name of a file, a `map` that is not a map bundle or
/// holds more than that. A folder that is not there is fine.
common::Result<void> check_replaceable(const std::filesystem::path& folder, ResultKind kind);

}  // namespace slamfuse::service
