// SPDX-License-Identifier: BSD-3-Clause
// The format: http://wiki.ros.org/Bags/Format/2.0. After the magic line come records: a header of named fields and
// data, each behind its length. Chunks hold connections (topics) and messages, perhaps compressed.
#include <algorithm>
#include <deque>
#include <fstream>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>

#include "common/ros_bag.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::size_t kLargestHeader = 1U << 20;  ///< bytes; a header holds a topic's name and a few numbers
constexpr std::size_t kInflateStep = 1U << 20;    ///< bytes; so a false size takes no memory
constexpr std::size_t kCacheBlocks = 8;           ///< bags written topic by topic jump between chunks
constexpr std::size_t kNoDamage = std::numeric_limits<std::size_t>::max();

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

Result<Bytes> inflate_bz2(ByteView stored, std::size_t size) {
  Bytes bytes;
  bz_stream stream{};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) return invalid_input("no memory to decompress");
  stream.next_in = const_cast<char*>(reinterpret_cast<const char*>(stored.data()));  // bzlib does not write to it
  stream.avail_in = static_cast<unsigned>(stored.size());
  int code = BZ_OK;
  while (code == BZ_OK && bytes.size() < size) {
    const std::size_t before = bytes.size();
    bytes.resize(std::min(size, before + kInflateStep));
    stream.next_out = reinterpret_cast<char*>(bytes.data() + before);
    stream.avail_out = static_cast<unsigned>(bytes.size() - before);
    code = BZ2_bzDecompress(&stream);
    bytes.resize(bytes.size() - stream.avail_out);
    if (code == BZ_OK && bytes.size() == before) break;  // wants more than there is
  }
  BZ2_bzDecompressEnd(&stream);
  if (bytes.size() != size) return invalid_input("its bz2 data is damaged or ends early");
  return bytes;
}

Result<Bytes> inflate_lz4(ByteView stored, std::size_t size) {
  Bytes bytes;
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) != 0) {
    return invalid_input("no memory to decompress");
  }
  while (bytes.size() < size) {
    const std::size_t before = bytes.size();
    bytes.resize(std::min(size, before + kInflateStep));
    std::size_t made = bytes.size() - before;
    std::size_t used = stored.size();
    const std::size_t code = LZ4F_decompress(context, bytes.data() + before, &made, stored.data(), &used, nullptr);
    bytes.resize(before + made);
    stored = stored.subspan(used);
    if (LZ4F_isError(code) != 0 || (made == 0 && used == 0)) break;
  }
  LZ4F_freeDecompressionContext(context);
  if (bytes.size() != size) return invalid_input("its lz4 data is damaged or ends early");
  return bytes;
}

/// A stretch of the file that is read as a whole: the data of a chunk, or of a message outside of chunks.
struct Block {
  std::uint64_t position = 0;  ///< in the file
  std::size_t stored_size = 0;
  std::size_t size = 0;  ///< decompressed
  std::string compression = "none";
};

/// Where a message stands, or a damaged place.
struct Entry {
  Nanoseconds stored = 0;
  std::size_t topic = 0;
  std::size_t block = 0;
  std::size_t offset = 0;  ///< in the decompressed block
  std::size_t size = 0;
  std::size_t damage = kNoDamage;
};

class Ros1Bag final : public RosBag {
 public:
  explicit Ros1Bag(fs::path path) : path_(std::move(path)), file_(path_, std::ios::binary) {}

  RosEncoding encoding() const override { return RosEncoding::kRos1; }
  const std::vector<RosTopic>& topics() const override { return topics_; }

  /// Reads the file through for where its messages stand.
  Result<void> index() {
    std::error_code code;
    file_size_ = fs::file_size(path_, code);
    if (!file_ || code) return invalid_input(path_.string() + ": cannot be read");
    position_ = kMagic.size();
    while (position_ < file_size_) {
      if (auto read = index_record(); !read) {
        add_damage(fmt::format("the record at byte {}: {}", position_, read.error().message));
        break;  // where the next record begins is not known
      }
    }
    if (damages_.size() == entries_.size() && !damages_.empty()) return invalid_input(damages_.front());
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.stored < b.stored; });
    return {};
  }

  void rewind(const std::set<std::size_t>& topics) override {
    wanted_ = topics;
    next_ = 0;
  }

  std::optional<RosBagItem> next() override {
    while (next_ < entries_.size()) {
      const Entry& entry = entries_[next_++];
      if (entry.damage != kNoDamage) return RosBagDamage{damages_[entry.damage]};
      if (!wanted_.contains(entry.topic)) continue;
      const auto block = cached(entry.block);
      // It was read before, when the bag was opened: only the disk, or another program, can be the reason.
      if (!block) return RosBagDamage{path_.string() + ": " + block.error().message};
      return RosBagMessage{entry.topic, entry.stored, ByteView(**block).subspan(entry.offset, entry.size)};
    }
    return std::nullopt;
  }

 private:
  /// Bytes of the file. Error: it ends before.
  Result<Bytes> read_at(std::uint64_t position, std::size_t size) {
    if (position > file_size_ || size > file_size_ - position) {
      return invalid_input(fmt::format("{} bytes at byte {}, but the file ends at {}", size, position, file_size_));
    }
    Bytes bytes(size);
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(position));
    file_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (!file_) return invalid_input(fmt::format("{} bytes at byte {} cannot be read", size, position));
    return bytes;
  }

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
      if (record->operation == kMessage) blocks_.push_back({data_at, *size, *size, "none"});
      if (auto done = take_in(*record, *data, 0); !done) return done;
    }
    position_ = data_at + *size;
    return {};
  }

  /// A chunk whose content is damaged costs what is in it; the next one is found all the same.
  Result<void> index_chunk(const Record& record, std::uint64_t data_at, std::size_t stored_size) {
    const auto size = record.number("size");
    blocks_.push_back({data_at, stored_size, size.value_or(0), record.text("compression")});
    if (data_at + stored_size > file_size_ && blocks_.back().compression == "none" && data_at < file_size_) {
      // The last chunk of a cut bag: what is there is whole up to the cut.
      blocks_.back().stored_size = blocks_.back().size = static_cast<std::size_t>(file_size_ - data_at);
    }
    const auto content = !size ? Result<const Bytes*>(invalid_input("no size")) : cached(blocks_.size() - 1);
    const auto done = content ? index_content(**content) : Result<void>(tl::unexpected(content.error()));
    if (!done) add_damage(fmt::format("the chunk at byte {}: {}", data_at, done.error().message));
    return {};
  }

  Result<void> index_content(ByteView content) {
    WireReader reader(content, false, 1);
    std::size_t at = 0;
    while (at < content.size()) {
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
      connections_[*connection] = index_of({record.text("topic"), Record{0, std::move(*fields)}.text("type")});
      return {};
    }
    const auto topic = connections_.find(*connection);
    const auto time = record.time();
    if (topic == connections_.end() || !time) return invalid_input("a message without known connection or time");
    entries_.push_back({*time, topic->second, blocks_.size() - 1, offset, data.size(), kNoDamage});
    latest_ = std::max(latest_, *time);
    return {};
  }

  std::size_t index_of(const RosTopic& topic) {
    const auto found = std::find_if(topics_.begin(), topics_.end(), [&](const RosTopic& known) {
      return known.name == topic.name && known.type == topic.type;
    });
    if (found != topics_.end()) return static_cast<std::size_t>(found - topics_.begin());
    topics_.push_back(topic);
    return topics_.size() - 1;
  }

  void add_damage(const std::string& reason) {
    entries_.push_back({latest_, 0, 0, 0, 0, damages_.size()});
    damages_.push_back(path_.string() + ": " + reason);
  }

  Result<Bytes> read_block(const Block& block) {
    if (block.size > kLargestBagBlock) return invalid_input(fmt::format("a size of {} bytes", block.size));
    auto stored = read_at(block.position, block.stored_size);
    if (!stored) return stored;
    if (block.compression == "bz2") return inflate_bz2(*stored, block.size);
    if (block.compression == "lz4") return inflate_lz4(*stored, block.size);
    if (block.compression != "none") {
      return invalid_input("compression '" + block.compression + "' (known: none, bz2, lz4)");
    }
    return stored;
  }

  /// The content of a block; valid until the next call.
  Result<const Bytes*> cached(std::size_t block) {
    const auto found =
        std::find_if(cache_.begin(), cache_.end(), [&](const auto& entry) { return entry.first == block; });
    if (found != cache_.end()) return &found->second;
    auto bytes = read_block(blocks_[block]);
    if (!bytes) return tl::unexpected(bytes.error());
    std::size_t held = bytes->size();
    for (const auto& entry : cache_) held += entry.second.size();
    while (!cache_.empty() && (cache_.size() >= kCacheBlocks || held > kLargestBagBlock)) {
      held -= cache_.front().second.size();
      cache_.pop_front();
    }
    cache_.emplace_back(block, std::move(*bytes));
    return &cache_.back().second;
  }

  fs::path path_;
  std::ifstream file_;
  std::uint64_t file_size_ = 0;
  std::uint64_t position_ = 0;
  std::vector<RosTopic> topics_;
  std::map<std::uint32_t, std::size_t> connections_;  ///< topics by connection
  std::vector<Block> blocks_;
  std::vector<Entry> entries_;
  std::vector<std::string> damages_;
  Nanoseconds latest_ = 0;
  std::set<std::size_t> wanted_;
  std::size_t next_ = 0;
  std::deque<std::pair<std::size_t, Bytes>> cache_;  ///< the oldest first
};

}  // namespace

bool is_ros1_bag(std::string_view beginning) { return beginning.starts_with(kMagic); }

Result<std::unique_ptr<RosBag>> open_ros1_bag(const fs::path& path) {
  auto bag = std::make_unique<Ros1Bag>(path);
  if (auto indexed = bag->index(); !indexed) return tl::unexpected(indexed.error());
  return bag;
}

}  // namespace slamfuse::common
