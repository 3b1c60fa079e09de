// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "common/error.hpp"

struct dds_qos;

namespace slamfuse::idl {

/// A participant's identity and permissions in a keystore of SROS2's layout.
struct Enclave {
  std::string name;              ///< "/slamfuse"
  std::filesystem::path folder;  ///< KEYSTORE/enclaves/slamfuse
};

/// The enclave of this name, with all its six files there. Error (kInvalidInput): the keystore or one of the files is
/// missing.
common::Result<Enclave> find_enclave(const std::filesystem::path& keystore, const std::string& name);

/// Adds DDS Security to a participant's settings: authentication, access control and encryption as the enclave says,
/// enforced.
void secure(dds_qos& qos, const Enclave& enclave);

}  // namespace slamfuse::idl
