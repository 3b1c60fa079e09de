// SPDX-License-Identifier: BSD-3-Clause
#include "service/landmark_file.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "service/checksum.hpp"

namespace slamfuse::service {
namespace {

static_assert(std::endian::native == std::endian::little, "the bytes are written as they lie in memory");

constexpr std::string_view kMagic = "SFLANDMK";
constexpr std::uint32_t kVersion = 3;  // with views
constexpr std::uint32_t kWithObjects = 2;
constexpr std::uint32_t kOldest = 1;
constexpr std::size_t kHeaderSize = kMagic.size() + 4 + 8 + 4;
/// The bytes of a landmark of the oldest version without a descriptor.
constexpr std::size_t kSmallestLandmark = 8 + 3 * 8 + 9 * 8 + 1 + 4 + 4;

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_bytes(std::string& bytes, const std::vector<std::uint8_t>& value) {
  append(bytes, static_cast<std::uint32_t>(value.size()));
  bytes.append(value.begin(), value.end());
}

/// Takes values off the front; `ok` turns false when the bytes run out.
struct Reader {
  std::string_view bytes;
  bool ok = true;

  template <class T>
  T take() {
    T value{};
    if (bytes.size() < sizeof value) {
      ok = false;
      return value;
    }
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes.remove_prefix(sizeof value);
    return value;
  }
  std::string_view take(std::size_t size) {
    if (bytes.size() < size) {
      ok = false;
      return {};
    }
    const std::string_view taken = bytes.substr(0, size);
    bytes.remove_prefix(size);
    return taken;
  }
};

tl::unexpected<common::Error> refused(const std::string& reason) {
  return common::invalid_input("landmark file: " + reason);
}

void append_landmark(std::string& bytes, const common::Landmark& landmark) {
  append(bytes, landmark.id);
  for (int i = 0; i < 3; ++i) append(bytes, landmark.position(i));
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) append(bytes, landmark.covariance(row, column));
  }
  append(bytes, landmark.gray);
  append(bytes, static_cast<std::int32_t>(landmark.observations));
  append_bytes(bytes, landmark.descriptor);
  append(bytes, static_cast<std::uint32_t>(landmark.object.size()));
  bytes += landmark.object;
  append(bytes, static_cast<std::uint32_t>(landmark.views.size()));
  for (const common::LandmarkView& view : landmark.views) {
    for (int i = 0; i < 3; ++i) append(bytes, view.direction(i));
    append_bytes(bytes, view.descriptor);
    append_bytes(bytes, view.patch);
  }
}

std::vector<std::uint8_t> take_bytes(Reader& reader) {
  const std::string_view bytes = reader.take(reader.take<std::uint32_t>());
  return {bytes.begin(), bytes.end()};
}

common::LandmarkView take_view(Reader& reader) {
  common::LandmarkView view;
  for (int i = 0; i < 3; ++i) view.direction(i) = reader.take<double>();
  view.descriptor = take_bytes(reader);
  view.patch = take_bytes(reader);
  return view;
}

common::Landmark take_landmark(Reader& reader, std::uint32_t version) {
  common::Landmark landmark;
  landmark.id = reader.take<std::int64_t>();
  for (int i = 0; i < 3; ++i) landmark.position(i) = reader.take<double>();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) landmark.covariance(row, column) = reader.take<double>();
  }
  landmark.gray = reader.take<std::uint8_t>();
  landmark.observations = reader.take<std::int32_t>();
  landmark.descriptor = take_bytes(reader);
  if (version >= kWithObjects) landmark.object = reader.take(reader.take<std::uint32_t>());
  if (version < kVersion) return landmark;
  const auto views = reader.take<std::uint32_t>();
  for (std::uint32_t i = 0; i < views && reader.ok; ++i) landmark.views.push_back(take_view(reader));
  return landmark;
}

}  // namespace

std::string landmarks_to_bytes(const std::vector<common::Landmark>& landmarks) {
  std::string payload;
  append(payload, static_cast<std::uint64_t>(landmarks.size()));
  for (const auto& landmark : landmarks) append_landmark(payload, landmark);

  std::string bytes(kMagic);
  append(bytes, kVersion);
  append(bytes, static_cast<std::uint64_t>(payload.size()));
  append(bytes, crc32_of(payload));
  return bytes + payload;
}

common::Result<std::vector<common::Landmark>> landmarks_from_bytes(std::string_view bytes) {
  if (bytes.size() < kHeaderSize || !bytes.starts_with(kMagic)) return refused("it does not start with SFLANDMK");
  Reader header{bytes.substr(kMagic.size())};
  const auto version = header.take<std::uint32_t>();
  const auto length = header.take<std::uint64_t>();
  const auto checksum = header.take<std::uint32_t>();
  if (version < kOldest || version > kVersion) {
    return refused(fmt::format("version {}, this program reads {} to {}", version, kOldest, kVersion));
  }
  if (length != header.bytes.size()) {
    return refused(fmt::format("{} bytes of payload, the header says {}", header.bytes.size(), length));
  }
  if (checksum != crc32_of(header.bytes)) return refused("the checksum does not match: the file was altered");

  Reader payload{header.bytes};
  const auto count = payload.take<std::uint64_t>();
  if (count > payload.bytes.size() / kSmallestLandmark) return refused(fmt::format("{} landmarks do not fit", count));
  std::vector<common::Landmark> landmarks;
  for (std::uint64_t i = 0; i < count && payload.ok; ++i) landmarks.push_back(take_landmark(payload, version));
  if (!payload.ok || !payload.bytes.empty()) return refused("the landmarks do not fill the payload");
  return landmarks;
}

}  // namespace slamfuse::service
