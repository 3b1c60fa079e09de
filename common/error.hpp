// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include <tl/expected.hpp>

namespace slamfuse::common {

/// What kind of thing went wrong; decides the exit status of the program (DESIGN section 5).
enum class ErrorKind {
  kUsage,         ///< wrong command line: exit 2
  kInvalidInput,  ///< unreadable structure (file, format, configuration, nothing in common in time): exit 3
  kFailed,        ///< the run itself failed or had nothing usable: exit 1
  kInterrupted,   ///< stopped by the user: exit 130
};

/// An error a caller can act on. The message names the file, line or key, the value found and what is allowed.
struct Error {
  ErrorKind kind = ErrorKind::kFailed;
  std::string message;
};

/// Either a value or an Error. Nothing below `main` prints or exits; failures travel in this type.
template <class T>
using Result = tl::expected<T, Error>;

/// Short forms for returning an error: `return invalid_input("...")`.
inline tl::unexpected<Error> usage_error(std::string message) {
  return tl::unexpected<Error>({ErrorKind::kUsage, std::move(message)});
}
inline tl::unexpected<Error> invalid_input(std::string message) {
  return tl::unexpected<Error>({ErrorKind::kInvalidInput, std::move(message)});
}
inline tl::unexpected<Error> failed(std::string message) {
  return tl::unexpected<Error>({ErrorKind::kFailed, std::move(message)});
}

}  // namespace slamfuse::common
