// SPDX-License-Identifier: BSD-3-Clause
#include "idl/waitset.hpp"

#include <dds/dds.h>

namespace slamfuse::idl {

common::Result<WaitSet> WaitSet::create(const Participant& participant) {
  return own(dds_create_waitset(participant.handle()), "make a waitset").map([&](Entity&& waitset) {
    return WaitSet(participant, std::move(waitset));
  });
}

common::Result<void> WaitSet::add(const UntypedReader& reader) {
  const dds_return_t code = dds_waitset_attach(waitset_.handle(), reader.condition(), 0);
  if (code != DDS_RETCODE_OK) return dds_failed("wait for a reader", code);
  return {};
}

bool WaitSet::wait(std::chrono::nanoseconds timeout) const {
  return dds_waitset_wait(waitset_.handle(), nullptr, 0, timeout.count()) > 0;
}

}  // namespace slamfuse::idl
