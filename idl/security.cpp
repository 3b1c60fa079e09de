// SPDX-License-Identifier: BSD-3-Clause
#include "idl/security.hpp"

#include <array>
#include <system_error>
#include <utility>

#include <dds/dds.h>

namespace slamfuse::idl {
namespace {

namespace fs = std::filesystem;

/// DDS Security's names for the files of an enclave.
constexpr std::array<std::pair<const char*, const char*>, 6> kFiles{
    {{"dds.sec.auth.identity_ca", "identity_ca.cert.pem"},
     {"dds.sec.auth.identity_certificate", "cert.pem"},
     {"dds.sec.auth.private_key", "key.pem"},
     {"dds.sec.access.permissions_ca", "permissions_ca.cert.pem"},
     {"dds.sec.access.governance", "governance.p7s"},
     {"dds.sec.access.permissions", "permissions.p7s"}}};

/// Cyclone's plugins.
constexpr std::array<std::pair<const char*, const char*>, 9> kPlugins{
    {{"dds.sec.auth.library.path", "dds_security_auth"},
     {"dds.sec.auth.library.init", "init_authentication"},
     {"dds.sec.auth.library.finalize", "finalize_authentication"},
     {"dds.sec.access.library.path", "dds_security_ac"},
     {"dds.sec.access.library.init", "init_access_control"},
     {"dds.sec.access.library.finalize", "finalize_access_control"},
     {"dds.sec.crypto.library.path", "dds_security_crypto"},
     {"dds.sec.crypto.library.init", "init_crypto"},
     {"dds.sec.crypto.library.finalize", "finalize_crypto"}}};

}  // namespace

common::Result<Enclave> find_enclave(const fs::path& keystore, const std::string& name) {
  const std::string plain = name.starts_with('/') ? name.substr(1) : name;
  Enclave enclave{"/" + plain, fs::absolute(keystore / "enclaves" / plain)};
  for (const auto& [property, file] : kFiles) {
    std::error_code code;
    if (fs::is_regular_file(enclave.folder / file, code)) continue;
    return common::invalid_input((enclave.folder / file).string() + ": no such file in the keystore");
  }
  return enclave;
}

void secure(dds_qos& qos, const Enclave& enclave) {
  for (const auto& [property, value] : kPlugins) dds_qset_prop(&qos, property, value);
  for (const auto& [property, file] : kFiles) {
    dds_qset_prop(&qos, property, ("file:" + (enclave.folder / file).string()).c_str());
  }
}

}  // namespace slamfuse::idl
