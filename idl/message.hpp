// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include <dds/ddsc/dds_public_alloc.h>

#include "idl/messages.hpp"

namespace slamfuse::idl {

/// The ROS name of a DDS type name "pkg::msg::dds_::Type_".
inline std::string ros_type_name(std::string dds_type) {
  constexpr std::string_view kMark = "dds_::";
  if (const auto mark = dds_type.find(kMark); mark != std::string::npos) dds_type.erase(mark, kMark.size());
  for (auto at = dds_type.find("::"); at != std::string::npos; at = dds_type.find("::"))
    dds_type.replace(at, 2, 1, '/');
  if (dds_type.ends_with('_')) dds_type.pop_back();
  return dds_type;
}

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

/// The name ROS 2 knows the type by, e.g. "sensor_msgs/msg/LaserScan".
template <class T>
std::string ros_type_name() {
  return ros_type_name(std::string(descriptor<T>().m_typename));
}

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
