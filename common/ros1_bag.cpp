// SPDX-License-Identifier: BSD-3-Clause
// The format: http://wiki.ros.org/Bags/Format/2.0. After the magic line come records: a header of named fields and
// data, each behind its length. Chunks hold connections (topics) and messages, perhaps compressed.
#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "common/indexed_bag.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::size_t kLargestHeader = 1U << 20;  ///< bytes; a header holds a topic's name and a few numbers

enum Operation : std::uint8_t { kMessage = 0x02, kChunk = 0x05, kConnection = 0x07 };

std::uint32_t little_endian_32(ByteView bytes) {
  return static_cast<std::uint32_t>(bytes[0]) | static_cast<std::uint32_t>(bytes[1]) << 8U |
         static_cast<std::uint32_t>(bytes[2]) << 16U | static_cast<std::uint32_t>(bytes[3]) << 24U;
}

/// The fields of a header by name. Error, the reason alone: a length that does not fit, a field without '='.
Result<std::map<std::string, ByteView>> parse_fields(ByteView header) {
  std::map<std::string, ByteView> fields;
  while (!header.empty()) {
    if (header.size() < sizeof(std::uint32_t)) return invalid_input("a header field is cut");
    const std::size_t length = little_endian_32(header);
    header = header.subspan(sizeof(std::uint32_t));
    if (length > header.size()) return invalid_input(fmt::format("a header field of {} bytes does not fit", length));
    const ByteView field = header.first(length);
    header = header.subspan(length);
    const auto equals = std::find(field.begin(), field.end(), static_cast<std::uint8_t>('='));
    if (equals == field.end()) return invalid_input("a header field without '='");
    fields[std::string(field.begin(), equals)] = ByteView(equals + 1, field.end());
  }
  return fields;
}

/// A record: what its header says, and where its data stand.
struct Record {
  std::uint8_t operation = 0;
  std::map<std::string, ByteView> fields;

  std::optional<std::uint32_t> number(const std::string& name) const {
    const auto field = fields.find(name);
    if (field == fields.end() || field->second.size() != sizeof(std::uint32_t)) return std::nullopt;
    return little_endian_32(field->second);
  }
  std::string text(const std::string& name) const {
    const auto field = fields.find(name);
    return field == fields.end() ? "" : std::string(field->second.begin(), field->second.end());
  }
  std::optional<Nanoseconds> time() const {
    const auto field = fields.find("time");
    if (field == fields.end() || field->second.size() != 2 * sizeof(std::uint32_t)) return std::nullopt;
    return Nanoseconds{little_endian_32(field->second)} * kNanosecondsPerSecond +
           little_endian_32(field->second.subspan(sizeof(std::uint32_t)));
  }
};

Result<Record> parse_record(ByteView header) {
  auto fields = parse_fields(header);
  if (!fields) return tl::unexpected(fields.error());
  const auto operation = fields->find("op");
  if (operation == fields->end() || operation->second.size() != 1) return invalid_input("a record without operation");
  return Record{operation->second.front(), std::move(*fields)};
}

class Ros1Bag final : public IndexedBag {
 public:
  RosEncoding encoding() const override { return RosEncoding::kRos1; }

  Result<void> index(const fs::path& path) {
    if (auto begun = begin_file(path); !begun) return begun;
    position_ = kMagic.size();
    while (position_ < file_size()) {
      if (auto read = index_record(); !read) {
        add_damage(fmt::format("the record at byte {}: {}", position_, read.error().message));
        break;  // where the next record begins is not known
      }
    }
    return finish();
  }

 private:
  Result<std::size_t> length_at(std::uint64_t position, std::size_t largest, const char* what) {
    const auto bytes = read_at(position, sizeof(std::uint32_t));
    if (!bytes) return tl::unexpected(bytes.error());
    const std::size_t length = little_endian_32(*bytes);
    if (length <= largest) return length;
    return invalid_input(fmt::format("{} of {} bytes (allowed: up to {})", what, length, largest));
  }

  /// Takes in the record at position_ and moves behind it.
  Result<void> index_record() {
    const auto header_size = length_at(position_, kLargestHeader, "a header");
    if (!header_size) return tl::unexpected(header_size.error());
    const std::uint64_t header_at = position_ + sizeof(std::uint32_t);
    const auto header = read_at(header_at, *header_size);
    if (!header) return tl::unexpected(header.error());
    const std::uint64_t size_at = header_at + *header_size;
    const auto size = length_at(size_at, kLargestBagBlock, "data");
    if (!size) return tl::unexpected(size.error());
    const std::uint64_t data_at = size_at + sizeof(std::uint32_t);
    const auto record = parse_record(*header);
    if (!record) return tl::unexpected(record.error());
    if (record->operation == kChunk) {
      if (auto done = index_chunk(*record, data_at, *size); !done) return done;
    } else if (record->operation == kMessage || record->operation == kConnection) {
      const auto data = read_at(data_at, *size);
      if (!data) return tl::unexpected(data.error());
      if (record->operation == kMessage) add_block({data_at, *size, *size});
      if (auto done = take_in(*record, *data, 0); !done) return done;
    }
    position_ = data_at + *size;
    return {};
  }

  /// A chunk whose content is damaged costs what is in it; the next one is found all the same.
  Result<void> index_chunk(const Record& record, std::uint64_t data_at, std::size_t stored_size) {
    const auto size = record.number("size");
    Block block{data_at, stored_size, size.value_or(0), record.text("compression")};
    if (data_at + stored_size > file_size() && block.compression == "none" && data_at < file_size()) {
      // The last chunk of a cut bag: what is there is whole up to the cut.
      block.stored_size = block.size = static_cast<std::size_t>(file_size() - data_at);
    }
    add_block(std::move(block));
    const auto bytes = !size ? Result<const Bytes*>(invalid_input("no size")) : content();
    const auto done = bytes ? index_content(**bytes) : Result<void>(tl::unexpected(bytes.error()));
    if (!done) add_damage(fmt::format("the chunk at byte {}: {}", data_at, done.error().message));
    return {};
  }

  Result<void> index_content(ByteView records) {
    WireReader reader(records, false, 1);
    std::size_t at = 0;
    while (at < records.size()) {
      const ByteView header = reader.take(reader.list_length(1));
      const std::size_t size = reader.list_length(1);
      const ByteView data = reader.take(size);
      if (!reader.problem().empty()) return invalid_input(reader.problem());
      const std::size_t data_at = at + 2 * sizeof(std::uint32_t) + header.size();
      const auto record = parse_record(header);
      if (!record) return tl::unexpected(record.error());
      if (auto done = take_in(*record, data, data_at); !done) return done;
      at = data_at + size;
    }
    return {};
  }

  /// A connection or a message whose data stand at `offset` of the last block.
  Result<void> take_in(const Record& record, ByteView data, std::size_t offset) {
    if (record.operation != kConnection && record.operation != kMessage) return {};
    const auto connection = record.number("conn");
    if (!connection) return invalid_input("a record without connection");
    if (record.operation == kConnection) {
      auto fields = parse_fields(data);
      if (!fields) return tl::unexpected(fields.error());
      connections_[*connection] = number_of({record.text("topic"), Record{0, std::move(*fields)}.text("type")});
      return {};
    }
    const auto topic = connections_.find(*connection);
    const auto time = record.time();
    if (topic == connections_.end() || !time) return invalid_input("a message without known connection or time");
    add_message(topic->second, *time, offset, data.size());
    return {};
  }

  std::uint64_t position_ = 0;
  std::map<std::uint32_t, std::size_t> connections_;  // topics by connection
};

}  // namespace

bool is_ros1_bag(std::string_view beginning) { return beginning.starts_with(kMagic); }

Result<std::unique_ptr<RosBag>> open_ros1_bag(const fs::path& path) {
  auto bag = std::make_unique<Ros1Bag>();
  if (auto indexed = bag->index(path); !indexed) return tl::unexpected(indexed.error());
  return bag;
}

}  // namespace slamfuse::common
