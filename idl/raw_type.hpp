// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

struct ddsi_sertype;
struct ddsi_serdata;

namespace slamfuse::idl {

/// A type of which only the name is known: its messages stay as they are on the wire, the four bytes of the
/// encapsulation header first. Uses what Cyclone 0.10 offers to other middlewares; ROS 2 messages have no keys. The
/// caller owns the reference; dds_create_topic_sertype() takes it over.
ddsi_sertype* make_raw_type(const std::string& dds_type_name);

/// The bytes of a message of any type as on the wire.
std::vector<std::uint8_t> bytes_of(ddsi_serdata& message);

/// A message of a raw type; null when the bytes are not even an encapsulation header.
ddsi_serdata* make_raw_message(const ddsi_sertype& type, std::span<const std::uint8_t> bytes);

}  // namespace slamfuse::idl
