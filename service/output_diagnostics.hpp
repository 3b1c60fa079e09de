// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "idl/output_health.hpp"
#include "service/input_diagnostics.hpp"

namespace slamfuse::service {

/// Says of every topic we publish how many listen to it, and names those who would and cannot (WARNING): another type
/// or a QoS policy keeps them away.
std::vector<Diagnosis> diagnose_outputs(const std::vector<idl::OutputHealth>& outputs);

}  // namespace slamfuse::service
