// SPDX-License-Identifier: BSD-3-Clause
#include "common/indexed_bag.hpp"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "common/inflate.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCacheBlocks = 8;  // bags written topic by topic jump between chunks

}  // namespace

void IndexedBag::rewind(const std::set<std::size_t>& topics) {
  wanted_ = topics;
  next_ = 0;
}

std::optional<RosBagItem> IndexedBag::next() {
  while (next_ < entries_.size()) {
    const Entry& entry = entries_[next_++];
    if (entry.damage != kNoDamage) return RosBagDamage{damages_[entry.damage]};
    if (!wanted_.contains(entry.topic)) continue;
    const auto block = cached(entry.block);
    // It was read before, when the bag was opened: only the disk, or another program, can be the reason.
    if (!block) return RosBagDamage{files_[blocks_[entry.block].file].path.string() + ": " + block.error().message};
    return RosBagMessage{entry.topic, entry.stored, ByteView(**block).subspan(entry.offset, entry.size)};
  }
  return std::nullopt;
}

Result<void> IndexedBag::begin_file(const fs::path& path) {
  std::error_code code;
  files_.push_back({path, fs::file_size(path, code)});
  if (code) return invalid_input(path.string() + ": cannot be read: " + code.message());
  return {};
}

Result<void> IndexedBag::finish() {
  if (damages_.size() == entries_.size() && !damages_.empty()) return invalid_input(damages_.front());
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.stored < b.stored; });
  return {};
}

Result<IndexedBag::Bytes> IndexedBag::read_at(std::uint64_t position, std::size_t size) {
  return read_from(files_.size() - 1, position, size);
}

Result<IndexedBag::Bytes> IndexedBag::read_from(std::size_t file, std::uint64_t position, std::size_t size) {
  const std::uint64_t end = files_[file].size;
  if (position > end || size > end - position) {
    return invalid_input(fmt::format("{} bytes at byte {}, but the file ends at {}", size, position, end));
  }
  if (open_file_ != file) {
    stream_ = std::ifstream(files_[file].path, std::ios::binary);
    open_file_ = file;
  }
  Bytes bytes(size);
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(position));
  stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  if (!stream_) return invalid_input(fmt::format("{} bytes at byte {} cannot be read", size, position));
  return bytes;
}

void IndexedBag::add_block(Block block) {
  block.file = files_.size() - 1;
  blocks_.push_back(std::move(block));
}

Result<const IndexedBag::Bytes*> IndexedBag::content() { return cached(blocks_.size() - 1); }

void IndexedBag::add_message(std::size_t topic, Nanoseconds stored, std::size_t offset, std::size_t size) {
  entries_.push_back({stored, topic, blocks_.size() - 1, offset, size, kNoDamage});
  latest_ = std::max(latest_, stored);
}

void IndexedBag::add_damage(const std::string& reason) {
  entries_.push_back({latest_, 0, 0, 0, 0, damages_.size()});
  damages_.push_back(files_.back().path.string() + ": " + reason);
}

Result<const IndexedBag::Bytes*> IndexedBag::cached(std::size_t index) {
  const auto found =
      std::find_if(cache_.begin(), cache_.end(), [&](const auto& entry) { return entry.first == index; });
  if (found != cache_.end()) return &found->second;
  const Block& block = blocks_[index];
  if (block.size > kLargestBagBlock) return invalid_input(fmt::format("a size of {} bytes", block.size));
  const auto stored = read_from(block.file, block.position, block.stored_size);
  if (!stored) return tl::unexpected(stored.error());
  auto bytes = inflate(block.compression, *stored, block.size);
  if (!bytes) return tl::unexpected(bytes.error());
  std::size_t held = bytes->size();
  for (const auto& entry : cache_) held += entry.second.size();
  while (!cache_.empty() && (cache_.size() >= kCacheBlocks || held > kLargestBagBlock)) {
    held -= cache_.front().second.size();
    cache_.pop_front();
  }
  cache_.emplace_back(index, std::move(*bytes));
  return &cache_.back().second;
}

}  // namespace slamfuse::common
