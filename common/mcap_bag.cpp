// SPDX-License-Identifier: BSD-3-Clause
// The format: https://mcap.dev/spec. Behind the magic bytes come records: a byte that tells which, a length of eight
// bytes, the content; all little-endian. Schemas name types, channels name topics, chunks hold schemas, channels and
// messages, perhaps compressed. The summary at the end says all of it again and is not needed.
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <zlib.h>

#include "common/indexed_bag.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;
using ByteView = std::span<const std::uint8_t>;

constexpr std::string_view kMagic = "\x89MCAP0\r\n";
constexpr std::size_t kRecordHead = 1 + sizeof(std::uint64_t);   // bytes before a record's content
constexpr std::size_t kMessageHead = 2 + 4 + 8 + 8;              // bytes before a message's data
constexpr std::uint64_t kLargestChunkHead = 8 + 8 + 8 + 4 + 64;  // bytes, with the name of the compression

enum Operation : std::uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kDataEnd = 0x0F
};

/// Which record comes, and how long its content is.
struct RecordHead {
  std::uint8_t operation = 0;
  std::uint64_t size = 0;
};

RecordHead read_head(WireReader& reader) {
  RecordHead head;
  head.operation = reader.number<std::uint8_t>();
  head.size = reader.number<std::uint64_t>();
  return head;
}

std::string read_text(WireReader& reader) {
  const ByteView text = reader.take(reader.list_length(1));
  return {text.begin(), text.end()};
}

class McapBag final : public IndexedBag {
 public:
  RosEncoding encoding() const override { return encoding_.value_or(RosEncoding::kCdr); }

  Result<void> index(const fs::path& path) {
    if (auto begun = begin_file(path); !begun) return begun;
    schemas_.clear();
    channels_.clear();
    const auto magic = read_at(0, kMagic.size());
    if (!magic || !is_mcap_file({reinterpret_cast<const char*>(magic->data()), magic->size()})) {
      return invalid_input(path.string() + ": not an MCAP file");
    }
    position_ = kMagic.size();
    ended_ = false;
    while (!ended_ && position_ < file_size()) {
      if (auto read = index_record(); !read) {
        add_damage(fmt::format("the record at byte {}: {}", position_, read.error().message));
        break;  // where the next record begins is not known
      }
    }
    return {};
  }

  Result<void> finish_files() { return finish(); }

 private:
  /// Takes in the record at position_ and moves behind it.
  Result<void> index_record() {
    const auto bytes = read_at(position_, kRecordHead);
    if (!bytes) return tl::unexpected(bytes.error());
    WireReader reader(*bytes, false, 1);
    const RecordHead head = read_head(reader);
    const std::uint64_t content_at = position_ + kRecordHead;
    const std::uint64_t left = file_size() - content_at;
    if (head.operation == kChunk) {
      if (auto done = index_chunk(content_at, std::min(head.size, left)); !done) return done;
    } else if (head.operation == kSchema || head.operation == kChannel || head.operation == kMessage) {
      if (head.size > kLargestBagBlock) return invalid_input(fmt::format("a size of {} bytes", head.size));
      const auto size = static_cast<std::size_t>(head.size);
      const auto record = read_at(content_at, size);
      if (!record) return tl::unexpected(record.error());
      if (head.operation == kMessage) add_block({content_at, size, size});
      if (auto done = take_in(head.operation, *record, 0); !done) return done;
    }
    ended_ = head.operation == kDataEnd || head.operation == kFooter;
    if (head.size > left)
      return invalid_input(fmt::format("{} bytes, but the file ends at {}", head.size, file_size()));
    position_ = content_at + head.size;
    return {};
  }

  /// A chunk whose content is damaged costs what is in it; the next one is found all the same. `size`: what is there.
  Result<void> index_chunk(std::uint64_t at, std::uint64_t size) {
    const auto bytes = read_at(at, static_cast<std::size_t>(std::min(size, kLargestChunkHead)));
    if (!bytes) return tl::unexpected(bytes.error());
    WireReader head(*bytes, false, 1);
    head.take(2 * sizeof(std::uint64_t));  // the times of the first and the last message
    const auto content_size = head.number<std::uint64_t>();
    const auto checksum = head.number<std::uint32_t>();
    const std::string compression = read_text(head);
    auto stored_size = head.number<std::uint64_t>();
    if (!head.problem().empty()) return invalid_input(head.problem());
    const std::uint64_t stored_at = sizeof(std::uint64_t) * 4 + sizeof(std::uint32_t) * 2 + compression.size();
    const bool cut = stored_size > size - stored_at;
    if (cut) stored_size = size - stored_at;
    if (content_size > kLargestBagBlock || stored_size > kLargestBagBlock) {
      return invalid_input(fmt::format("a chunk of {} bytes", content_size));
    }
    // Of a chunk that was cut, what is there is whole up to the cut, if it is not compressed.
    const bool as_is = compression.empty() && cut;
    add_block({at + stored_at, static_cast<std::size_t>(stored_size),
               static_cast<std::size_t>(as_is ? stored_size : content_size), compression});
    const auto records = content();
    const bool right =
        !records || checksum == 0 || cut || crc32_z(0, (*records)->data(), (*records)->size()) == checksum;
    const auto done = !records ? Result<void>(tl::unexpected(records.error()))
                      : !right ? invalid_input("its checksum does not fit")
                               : index_content(**records);
    if (!done) add_damage(fmt::format("the chunk at byte {}: {}", at, done.error().message));
    return {};
  }

  Result<void> index_content(ByteView records) {
    WireReader reader(records, false, 1);
    std::size_t at = 0;
    while (at < records.size()) {
      const RecordHead head = read_head(reader);
      const ByteView record = reader.take(static_cast<std::size_t>(head.size));
      if (!reader.problem().empty()) return invalid_input(reader.problem());
      if (auto done = take_in(head.operation, record, at + kRecordHead); !done) return done;
      at += kRecordHead + record.size();
    }
    return {};
  }

  /// A schema, a channel or a message that stands at `offset` of the last block.
  Result<void> take_in(std::uint8_t operation, ByteView record, std::size_t offset) {
    WireReader reader(record, false, 1);
    if (operation == kSchema) {
      const auto id = reader.number<std::uint16_t>();
      schemas_[id] = read_text(reader);
    } else if (operation == kChannel) {
      add_channel(reader);
    } else if (operation == kMessage) {
      const auto channel = reader.number<std::uint16_t>();
      reader.number<std::uint32_t>();  // counts the messages of the channel
      const auto time = reader.number<std::uint64_t>();
      if (record.size() < kMessageHead) return invalid_input("a message is cut");
      const auto known = channels_.find(channel);
      if (known == channels_.end()) return invalid_input(fmt::format("a message of the unknown channel {}", channel));
      if (!known->second) return {};
      add_message(*known->second, static_cast<Nanoseconds>(time), offset + kMessageHead, record.size() - kMessageHead);
    }
    return reader.problem().empty() ? Result<void>{} : invalid_input(reader.problem());
  }

  /// Channels of other encodings than the first of ROS (protobuf, JSON) hold nothing that could be read.
  void add_channel(WireReader& reader) {
    const auto id = reader.number<std::uint16_t>();
    const auto schema = reader.number<std::uint16_t>();
    const std::string topic = read_text(reader);
    const std::string name = read_text(reader);
    std::optional<RosEncoding> encoding;
    if (name == "cdr") encoding = RosEncoding::kCdr;
    if (name == "ros1") encoding = RosEncoding::kRos1;
    if (!encoding_) encoding_ = encoding;
    const bool usable = encoding && encoding == encoding_;
    channels_[id] = usable ? std::optional(number_of({topic, schemas_[schema]})) : std::nullopt;
  }

  std::uint64_t position_ = 0;
  bool ended_ = false;
  std::optional<RosEncoding> encoding_;
  std::map<std::uint16_t, std::string> schemas_;                  // names of types
  std::map<std::uint16_t, std::optional<std::size_t>> channels_;  // topics, none where they cannot be read
};

}  // namespace

bool is_mcap_file(std::string_view beginning) { return beginning.starts_with(kMagic); }

Result<std::unique_ptr<RosBag>> open_mcap_bag(const std::vector<fs::path>& files) {
  auto bag = std::make_unique<McapBag>();
  for (const fs::path& file : files) {
    if (auto indexed = bag->index(file); !indexed) return tl::unexpected(indexed.error());
  }
  if (auto finished = bag->finish_files(); !finished) return tl::unexpected(finished.error());
  return bag;
}

}  // namespace slamfuse::common
