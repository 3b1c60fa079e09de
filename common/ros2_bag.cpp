// SPDX-License-Identifier: BSD-3-Clause
#include <sqlite3.h>

#include <algorithm>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "common/ros_bag.hpp"
#include "common/topic_numbers.hpp"

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSqliteHead{"SQLite format 3\0", 16};
constexpr const char* kDatabaseExtension = ".db3";
constexpr const char* kMcapExtension = ".mcap";
constexpr std::uintmax_t kLargestMetadata = 1U << 22;  ///< bytes

struct DatabaseCloser {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct StatementCloser {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::unique_ptr<sqlite3, DatabaseCloser>;
using Statement = std::unique_ptr<sqlite3_stmt, StatementCloser>;

/// "file:" with all that an URI would read otherwise written as %xx.
std::string uri_of(const fs::path& path, bool immutable) {
  std::string uri = "file:";
  for (const char c : path.string()) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '/' ||
                       c == '.' || c == '_' || c == '-';
    uri += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return uri + (immutable ? "?mode=ro&immutable=1" : "?mode=ro");
}

Result<Database> open_database(const fs::path& path) {
  // Without a write-ahead log beside it SQLite need not write anything to read it, not even a lock.
  std::error_code code;
  const bool immutable = !fs::exists(path.string() + "-wal", code);
  sqlite3* raw = nullptr;
  const int opened =
      sqlite3_open_v2(uri_of(path, immutable).c_str(), &raw, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
  Database database(raw);
  if (opened != SQLITE_OK) {
    return invalid_input(fmt::format("{}: cannot be opened: {}", path.string(), sqlite3_errstr(opened)));
  }
  sqlite3_limit(raw, SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestBagBlock));
  return database;
}

Result<Statement> prepare(sqlite3* database, const fs::path& path, const std::string& sql) {
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database, sql.c_str(), -1, &raw, nullptr) != SQLITE_OK) {
    return invalid_input(fmt::format("{}: not a ROS 2 bag: {}", path.string(), sqlite3_errmsg(database)));
  }
  return Statement(raw);
}

std::string column_text(sqlite3_stmt* statement, int column) {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement, column));
  return text != nullptr ? text : "";
}

/// One .db3 file.
struct StorageFile {
  fs::path path;
  Database database;
  std::map<std::int64_t, std::size_t> topics;  ///< by their id in this file
};

class Ros2Bag final : public RosBag {
 public:
  RosEncoding encoding() const override { return RosEncoding::kCdr; }
  const std::vector<RosTopic>& topics() const override { return numbers_.topics(); }

  Result<void> add_file(const fs::path& path) {
    auto database = open_database(path);
    if (!database) return tl::unexpected(database.error());
    StorageFile file{path, std::move(*database), {}};
    auto statement =
        prepare(file.database.get(), path, "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    if (!statement) return tl::unexpected(statement.error());
    int code = SQLITE_OK;
    while ((code = sqlite3_step(statement->get())) == SQLITE_ROW) {
      const std::string name = column_text(statement->get(), 1);
      const std::string format = column_text(statement->get(), 3);
      if (format != "cdr") {
        return invalid_input(
            fmt::format("{}: topic {} is serialised as '{}' (known: cdr)", path.string(), name, format));
      }
      file.topics[sqlite3_column_int64(statement->get(), 0)] =
          numbers_.number_of({name, column_text(statement->get(), 2)});
    }
    if (code != SQLITE_DONE) return invalid_input(damage_of(file));
    files_.push_back(std::move(file));
    return {};
  }

  void rewind(const std::set<std::size_t>& topics) override {
    wanted_ = topics;
    next_file_ = 0;
    statement_.reset();
  }

  std::optional<RosBagItem> next() override {
    while (true) {
      if (!statement_) {
        if (next_file_ == files_.size()) return std::nullopt;
        if (auto begun = begin_file(); !begun) return RosBagDamage{begun.error().message};
      }
      const StorageFile& file = files_[next_file_ - 1];
      const int code = sqlite3_step(statement_.get());
      if (code == SQLITE_DONE) {
        statement_.reset();
        continue;
      }
      if (code != SQLITE_ROW) {
        RosBagDamage damage{damage_of(file)};
        statement_.reset();
        return damage;
      }
      const auto topic = file.topics.find(sqlite3_column_int64(statement_.get(), 0));
      if (topic == file.topics.end()) continue;
      const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_.get(), 2));
      const auto size = data != nullptr ? static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), 2)) : 0;
      return RosBagMessage{topic->second, sqlite3_column_int64(statement_.get(), 1), {data, size}};
    }
  }

 private:
  static std::string damage_of(const StorageFile& file) {
    return fmt::format("{}: the database is damaged or cut: {}", file.path.string(),
                       sqlite3_errmsg(file.database.get()));
  }

  Result<void> begin_file() {
    const StorageFile& file = files_[next_file_++];
    std::string ids;
    for (const auto& [id, topic] : file.topics) {
      if (wanted_.contains(topic)) ids += (ids.empty() ? "" : ",") + std::to_string(id);
    }
    auto statement = prepare(
        file.database.get(), file.path,
        "SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids + ") ORDER BY timestamp, id");
    if (!statement) return tl::unexpected(statement.error());
    statement_ = std::move(*statement);
    return {};
  }

  TopicNumbers numbers_;
  std::vector<StorageFile> files_;
  std::set<std::size_t> wanted_;
  std::size_t next_file_ = 0;
  Statement statement_;  ///< reads the file before next_file_
};

/// The files of an extension in a folder, by name.
std::vector<fs::path> files_with(const char* extension, const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::directory_iterator entry(folder, code); !code && entry != fs::directory_iterator(); entry.increment(code)) {
    if (entry->path().extension() == extension) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    // bag_10.db3 comes behind bag_9.db3.
    const std::string left = a.filename().string();
    const std::string right = b.filename().string();
    return std::pair(left.size(), left) < std::pair(right.size(), right);
  });
  return files;
}

/// The files of a bag, all of one storage.
struct BagFiles {
  std::vector<fs::path> paths;
  bool mcap = false;
};

/// The files a metadata.yaml names.
Result<BagFiles> files_of_metadata(const fs::path& metadata) {
  const auto refuse = [&](const std::string& problem) { return invalid_input(metadata.string() + ": " + problem); };
  std::error_code code;
  if (fs::file_size(metadata, code) > kLargestMetadata || code) return refuse("not readable, or larger than 4 MiB");
  try {
    const YAML::Node info = YAML::LoadFile(metadata.string())["rosbag2_bagfile_information"];
    if (!info) return refuse("key rosbag2_bagfile_information is missing");
    const auto storage = info["storage_identifier"].as<std::string>();
    if (storage != "sqlite3" && storage != "mcap") {
      return refuse("storage_identifier is '" + storage + "' (known: sqlite3, mcap)");
    }
    const auto compression = info["compression_mode"].as<std::string>("");
    if (!compression.empty() && compression != "none") {
      return refuse("compression_mode is '" + compression + "'; compressed bags are not read (`ros2 bag convert`)");
    }
    BagFiles files{{}, storage == "mcap"};
    for (const YAML::Node& file : info["relative_file_paths"]) {
      // Early versions wrote the folder's name too; no file lies elsewhere.
      files.paths.push_back(metadata.parent_path() / fs::path(file.as<std::string>()).filename());
    }
    if (files.paths.empty()) return refuse("relative_file_paths names no file");
    return files;
  } catch (const YAML::Exception& error) {
    return refuse(error.what());
  }
}

/// The files in a folder, or the one file.
Result<BagFiles> files_of(const fs::path& path) {
  std::error_code code;
  if (!fs::is_directory(path, code)) return BagFiles{{path}, path.extension() == kMcapExtension};
  if (fs::exists(path / "metadata.yaml", code)) return files_of_metadata(path / "metadata.yaml");
  BagFiles files{files_with(kDatabaseExtension, path)};
  if (files.paths.empty()) files = {files_with(kMcapExtension, path), true};
  return files;
}

}  // namespace

bool is_sqlite_file(std::string_view beginning) { return beginning.starts_with(kSqliteHead); }

bool is_ros2_bag_folder(const fs::path& path) {
  std::error_code code;
  if (!files_with(kDatabaseExtension, path).empty() || !files_with(kMcapExtension, path).empty()) return true;
  if (!fs::is_regular_file(path / "metadata.yaml", code)) return false;
  return fs::file_size(path / "metadata.yaml", code) > 0;
}

Result<std::unique_ptr<RosBag>> open_ros2_bag(const fs::path& path) {
  const Result<BagFiles> files = files_of(path);
  if (!files) return tl::unexpected(files.error());
  if (files->mcap) return open_mcap_bag(files->paths);
  auto bag = std::make_unique<Ros2Bag>();
  for (const fs::path& file : files->paths) {
    if (auto added = bag->add_file(file); !added) return tl::unexpected(added.error());
  }
  return bag;
}

}  // namespace slamfuse::common
