// SPDX-License-Identifier: BSD-3-Clause
#include "service/diagnostics_publisher.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <iterator>
#include <map>
#include <mutex>
#include <utility>

#include "idl/output_health.hpp"
#include "idl/writer.hpp"
#include "service/clock_now.hpp"
#include "service/input_diagnostics.hpp"
#include "service/output_diagnostics.hpp"

namespace slamfuse::service {
namespace {

constexpr std::chrono::seconds kPeriod{1};

/// Waits; false when it is time to end.
bool sleep(const std::stop_token& done) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, done, kPeriod, [] { return false; });
  return !done.stop_requested();
}

}  // namespace

common::Result<std::unique_ptr<DiagnosticsPublisher>> DiagnosticsPublisher::start(
    const idl::Participant& participant, idl::GraphPresence presence, const std::string& node, const LiveSource& source,
    const std::function<void(const std::string&)>& tell) {
  auto made = idl::Writer<idl::DiagnosticArray>::create(participant, "diagnostics", idl::QosProfile::kOutput);
  if (!made) return tl::unexpected(made.error());
  auto outputs = idl::Outputs::create(participant);
  if (!outputs) return tl::unexpected(outputs.error());

  std::unique_ptr<DiagnosticsPublisher> publisher(new DiagnosticsPublisher);
  publisher->thread_ = std::jthread([&source, tell, node, writer = *std::move(made), outputs = *std::move(outputs),
                                     presence = std::move(presence)](const std::stop_token& done) mutable {
    InputDiagnostics diagnostics;
    std::map<std::pair<Direction, std::string>, DiagnosisLevel> told;
    while (sleep(done)) {
      static_cast<void>(presence.update());  // topics work without
      auto diagnoses = diagnostics.look(source.inputs(), std::chrono::steady_clock::now());
      std::ranges::move(diagnose_outputs(outputs.look()), std::back_inserter(diagnoses));
      // A failure to send is no news: a reader that does not keep up misses a second.
      static_cast<void>(writer.write(to_ros_diagnostics(clock_now(), node, diagnoses)));
      for (const Diagnosis& diagnosis : diagnoses) {
        const auto before = std::exchange(told[{diagnosis.direction, diagnosis.topic}], diagnosis.level);
        const std::string which = diagnosis.direction == Direction::kOutput ? "output " : "";
        if (diagnosis.level != before) tell(which + diagnosis.topic + ": " + diagnosis.message);
      }
    }
  });
  return publisher;
}

}  // namespace slamfuse::service
