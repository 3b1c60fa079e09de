// SPDX-License-Identifier: BSD-3-Clause
#include "service/output_diagnostics.hpp"

#include <string>

#include <fmt/format.h>

namespace slamfuse::service {
namespace {

std::string in_words(int readers) {
  if (readers == 0) return "nobody listens";
  return readers == 1 ? "1 reader" : fmt::format("{} readers", readers);
}

}  // namespace

std::vector<Diagnosis> diagnose_outputs(const std::vector<idl::OutputHealth>& outputs) {
  std::vector<Diagnosis> diagnoses;
  for (const idl::OutputHealth& output : outputs) {
    Diagnosis diagnosis{output.topic, DiagnosisLevel::kOk, in_words(output.readers), {}, Direction::kOutput};
    diagnosis.values = {{"type", output.type}, {"readers", std::to_string(output.readers)}};
    for (const idl::RefusedReader& refused : output.refused) {
      diagnosis.level = DiagnosisLevel::kWarning;
      diagnosis.message += fmt::format("; {} gets nothing: {}", refused.who, refused.why);
    }
    diagnoses.push_back(std::move(diagnosis));
  }
  return diagnoses;
}

}  // namespace slamfuse::service
