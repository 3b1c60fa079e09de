// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <fstream>
#include <limits>
#include <utility>

#include "common/ros_bag.hpp"
#include "common/topic_numbers.hpp"

namespace slamfuse::common {

/// A bag of files that are read through once when they are opened, for where their messages stand: an index inside the
/// files is not needed, so a bag that was never closed can be read too. Formats derive from it and take in records.
class IndexedBag : public RosBag {
 public:
  const std::vector<RosTopic>& topics() const override { return numbers_.topics(); }
  void rewind(const std::set<std::size_t>& topics) override;
  std::optional<RosBagItem> next() override;

 protected:
  using Bytes = std::vector<std::uint8_t>;
  using ByteView = std::span<const std::uint8_t>;

  /// A stretch of a file that is read as a whole: the data of a chunk, or of a message outside of chunks.
  struct Block {
    std::uint64_t position = 0;  ///< in the file
    std::size_t stored_size = 0;
    std::size_t size = 0;  ///< decompressed
    std::string compression = "none";
    std::size_t file = 0;  ///< set by add_block()
  };

  /// Begins a file: what is read and added from here on is of this one. Error: it cannot be read.
  Result<void> begin_file(const std::filesystem::path& path);
  /// After the last file: messages in the order of their times. Error: damage only, no message.
  Result<void> finish();

  std::uint64_t file_size() const { return files_.back().size; }
  /// Bytes of the file. Error, the reason alone: it ends before.
  Result<Bytes> read_at(std::uint64_t position, std::size_t size);

  /// The block that messages added from here on stand in.
  void add_block(Block block);
  /// The content of that block, valid until another is read. Error, the reason alone: unreadable, damaged, too large.
  Result<const Bytes*> content();
  std::size_t number_of(RosTopic topic) { return numbers_.number_of(std::move(topic)); }
  /// A message at `offset` of the block.
  void add_message(std::size_t topic, Nanoseconds stored, std::size_t offset, std::size_t size);
  /// A place that cannot be read, told when the messages before it have been.
  void add_damage(const std::string& reason);

 private:
  static constexpr std::size_t kNoDamage = std::numeric_limits<std::size_t>::max();
  /// Where a message stands, or a damaged place.
  struct Entry {
    Nanoseconds stored = 0;
    std::size_t topic = 0;
    std::size_t block = 0;
    std::size_t offset = 0;
    std::size_t size = 0;
    std::size_t damage = kNoDamage;
  };
  struct File {
    std::filesystem::path path;
    std::uint64_t size = 0;
  };

  Result<Bytes> read_from(std::size_t file, std::uint64_t position, std::size_t size);
  Result<const Bytes*> cached(std::size_t block);

  std::vector<File> files_;
  std::ifstream stream_;  ///< of files_[open_file_]; one at a time, bags may be split into hundreds
  std::size_t open_file_ = std::numeric_limits<std::size_t>::max();
  TopicNumbers numbers_;
  std::vector<Block> blocks_;
  std::vector<Entry> entries_;
  std::vector<std::string> damages_;
  Nanoseconds latest_ = 0;
  std::set<std::size_t> wanted_;
  std::size_t next_ = 0;
  std::deque<std::pair<std::size_t, Bytes>> cache_;  ///< the oldest first
};

}  // namespace slamfuse::common
