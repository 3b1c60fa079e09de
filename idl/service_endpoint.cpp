// SPDX-License-Identifier: BSD-3-Clause
#include "idl/service_endpoint.hpp"

#include <atomic>
#include <utility>

#include <fmt/format.h>

#include <dds/dds.h>

#include "idl/qos.hpp"

namespace slamfuse::idl {
namespace {

constexpr const char* kClientMark = "clientid=";
constexpr const char* kServerMark = "serviceid=";

/// 16 bytes that no other service or client has: the participant's, the last four replaced by a count.
std::string unique_id(const Participant& participant) {
  static std::atomic<std::uint32_t> count{0};
  const std::uint32_t number = ++count;
  dds_guid_t guid{};
  dds_get_guid(participant.handle(), &guid);
  constexpr int kOwnBytes = 12;
  constexpr int kBytes = 16;
  std::string text;
  for (int i = 0; i < kBytes; ++i) {
    const int byte = i < kOwnBytes ? guid.v[i] : static_cast<int>((number >> (8 * (kBytes - 1 - i))) & 0xffU);
    text += fmt::format("{}{:x}", i == 0 ? "" : ".", byte);
  }
  return text;
}

}  // namespace

common::Result<ServiceEndpoint> ServiceEndpoint::create(const Participant& participant, Side side,
                                                        const std::string& name, const dds_topic_descriptor& request,
                                                        const dds_topic_descriptor& response) {
  const bool server = side == Side::kServer;
  const UniqueQos qos = make_qos(QosProfile::kOutput);
  const std::string user_data = (server ? kServerMark : kClientMark) + unique_id(participant) + ";";
  dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
  const std::string requests = "rq/" + name + "Request";
  const std::string replies = "rr/" + name + "Reply";
  auto reader = UntypedReader::create(participant, server ? request : response, server ? requests : replies, *qos);
  if (!reader) return tl::unexpected(reader.error());
  auto writer = UntypedWriter::create(participant, server ? response : request, server ? replies : requests, *qos);
  if (!writer) return tl::unexpected(writer.error());
  return ServiceEndpoint{*std::move(reader), *std::move(writer)};
}

bool is_client(const std::string& user_data) { return user_data.find(kClientMark) != std::string::npos; }

}  // namespace slamfuse::idl
