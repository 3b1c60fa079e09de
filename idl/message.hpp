// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <type_traits>

#include <dds/ddsc/dds_public_alloc.h>

#include "idl/messages.hpp"

namespace slamfuse::idl {

/// Owns one message and everything it points to (strings, sequences), starting as all zeros. Moves, does not copy.
template <class T>
class Message {
 public:
  Message() : sample_(static_cast<T*>(dds_alloc(sizeof(T)))) {}  // dds_alloc zeroes

  T& operator*() { return *sample_; }
  const T& operator*() const { return *sample_; }
  T* operator->() { return sample_.get(); }
  const T* operator->() const { return sample_.get(); }

 private:
  struct Free {
    void operator()(T* sample) const { dds_sample_free(sample, &descriptor<T>(), DDS_FREE_ALL); }
  };
  std::unique_ptr<T, Free> sample_;
};

/// Replaces a string field of a message. The text ends at its first NUL, as on the wire.
inline void assign(char*& field, const std::string& text) {
  dds_free(field);
  field = dds_string_dup(text.c_str());
}

/// A string field as text; empty where the field was never set.
inline std::string text_of(const char* field) { return field == nullptr ? std::string() : std::string(field); }

/// Gives an empty sequence field of a message `size` zeroed elements.
template <class Sequence>
void allocate(Sequence& sequence, std::size_t size) {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  sequence._buffer = size == 0 ? nullptr : static_cast<Element*>(dds_alloc(size * sizeof(Element)));
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(size);
  sequence._release = true;
}

}  // namespace slamfuse::idl
