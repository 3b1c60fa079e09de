// SPDX-License-Identifier: BSD-3-Clause
#include "idl/raw_type.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>
#include <dds/ddsi/q_radmin.h>

namespace slamfuse::idl {
namespace {

constexpr std::size_t kHeaderBytes = 4;
constexpr std::size_t kWordBytes = 4;  // what Cyclone reads goes up to a multiple of this

struct RawMessage : ddsi_serdata {
  RawMessage(const ddsi_sertype* of, ddsi_serdata_kind data_kind, std::size_t bytes)
      : ddsi_serdata(), size(bytes), padded((bytes + kWordBytes - 1) / kWordBytes * kWordBytes) {
    ddsi_serdata_init(this, of, data_kind);
  }
  std::size_t size;
  std::vector<std::uint8_t> padded;
};

const RawMessage& raw(const ddsi_serdata* message) { return *static_cast<const RawMessage*>(message); }

// ---- a message

bool same_key(const ddsi_serdata* /*a*/, const ddsi_serdata* /*b*/) { return true; }  // there are no keys

std::uint32_t size_of(const ddsi_serdata* message) { return static_cast<std::uint32_t>(raw(message).size); }

ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                             std::size_t size) {
  auto* const message = new RawMessage(type, kind, size);
  std::size_t filled = 0;
  for (; fragment != nullptr; fragment = fragment->nextfrag) {
    if (fragment->maxp1 <= filled) continue;  // nothing new in it
    const unsigned char* const payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
    std::memcpy(message->padded.data() + filled, payload + (filled - fragment->min), end - filled);
    filled = end;
  }
  return message;
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, std::size_t size) {
  auto* const message = new RawMessage(type, kind, size);
  std::size_t filled = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && filled < size; ++i) {
    const std::size_t length = std::min<std::size_t>(pieces[i].iov_len, size - filled);
    std::memcpy(message->padded.data() + filled, pieces[i].iov_base, length);
    filled += length;
  }
  return message;
}

ddsi_serdata* from_keyhash(const ddsi_sertype* type, const ddsi_keyhash* /*keyhash*/) {
  return new RawMessage(type, SDK_KEY, 0);
}

// Raw messages are neither written nor read as C structs.
ddsi_serdata* from_sample(const ddsi_sertype* /*type*/, ddsi_serdata_kind /*kind*/, const void* /*sample*/) {
  return nullptr;
}
bool to_sample(const ddsi_serdata* /*message*/, void* /*sample*/, void** /*buffer*/, void* /*end*/) { return false; }
bool untyped_to_sample(const ddsi_sertype* /*type*/, const ddsi_serdata* /*message*/, void* /*sample*/,
                       void** /*buffer*/, void* /*end*/) {
  return true;
}

void to_bytes(const ddsi_serdata* message, std::size_t offset, std::size_t size, void* buffer) {
  std::memcpy(buffer, raw(message).padded.data() + offset, size);
}

ddsi_serdata* to_reference(const ddsi_serdata* message, std::size_t offset, std::size_t size,
                           ddsrt_iovec_t* reference) {
  reference->iov_base = const_cast<std::uint8_t*>(raw(message).padded.data() + offset);
  reference->iov_len = size;
  return ddsi_serdata_ref(message);
}

void end_reference(ddsi_serdata* message, const ddsrt_iovec_t* /*reference*/) { ddsi_serdata_unref(message); }

ddsi_serdata* to_untyped(const ddsi_serdata* message) {
  auto* const key = new RawMessage(message->type, SDK_KEY, 0);
  key->type = nullptr;
  return key;
}

void free_message(ddsi_serdata* message) { delete static_cast<RawMessage*>(message); }

std::size_t print(const ddsi_sertype* /*type*/, const ddsi_serdata* /*message*/, char* buffer, std::size_t size) {
  if (size > 0) *buffer = '\0';
  return 0;
}

void keyhash_of(const ddsi_serdata* /*message*/, ddsi_keyhash* keyhash, bool /*force_md5*/) {
  std::memset(keyhash, 0, sizeof(*keyhash));
}

const ddsi_serdata_ops& message_operations() {
  static const ddsi_serdata_ops kOperations = [] {
    ddsi_serdata_ops operations{};
    operations.eqkey = same_key;
    operations.get_size = size_of;
    operations.from_ser = from_fragments;
    operations.from_ser_iov = from_pieces;
    operations.from_keyhash = from_keyhash;
    operations.from_sample = from_sample;
    operations.to_ser = to_bytes;
    operations.to_ser_ref = to_reference;
    operations.to_ser_unref = end_reference;
    operations.to_sample = to_sample;
    operations.to_untyped = to_untyped;
    operations.untyped_to_sample = untyped_to_sample;
    operations.free = free_message;
    operations.print = print;
    operations.get_keyhash = keyhash_of;
    return operations;
  }();
  return kOperations;
}

// ---- its type

struct RawType : ddsi_sertype {};

void free_type(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<RawType*>(type);
}

void zero_samples(const ddsi_sertype* /*type*/, void* /*samples*/, std::size_t /*count*/) {}
void realloc_samples(void** /*samples*/, const ddsi_sertype* /*type*/, void* /*old*/, std::size_t /*old_count*/,
                     std::size_t /*count*/) {}
void free_samples(const ddsi_sertype* /*type*/, void** /*samples*/, std::size_t /*count*/, dds_free_op_t /*what*/) {}

bool same_type(const ddsi_sertype* /*a*/, const ddsi_sertype* /*b*/) { return true; }  // names were compared before
std::uint32_t hash_of(const ddsi_sertype* /*type*/) { return 0; }

const ddsi_sertype_ops& type_operations() {
  static const ddsi_sertype_ops kOperations = [] {
    ddsi_sertype_ops operations{};
    operations.version = ddsi_sertype_v0;
    operations.free = free_type;
    operations.zero_samples = zero_samples;
    operations.realloc_samples = realloc_samples;
    operations.free_samples = free_samples;
    operations.equal = same_type;
    operations.hash = hash_of;
    return operations;
  }();
  return kOperations;
}

}  // namespace

ddsi_sertype* make_raw_type(const std::string& dds_type_name) {
  auto* const type = new RawType();
  constexpr bool kNoKey = true;
  ddsi_sertype_init(type, dds_type_name.c_str(), &type_operations(), &message_operations(), kNoKey);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

std::vector<std::uint8_t> bytes_of(ddsi_serdata& message) {
  std::vector<std::uint8_t> bytes(ddsi_serdata_size(&message));
  ddsi_serdata_to_ser(&message, 0, bytes.size(), bytes.data());
  return bytes;
}

ddsi_serdata* make_raw_message(const ddsi_sertype& type, std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHeaderBytes) return nullptr;
  ddsrt_iovec_t piece{};
  piece.iov_base = const_cast<std::uint8_t*>(bytes.data());
  piece.iov_len = bytes.size();
  return ddsi_serdata_from_ser_iov(&type, SDK_DATA, 1, &piece, bytes.size());
}

}  // namespace slamfuse::idl
