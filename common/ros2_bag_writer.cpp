// SPDX-License-Identifier: BSD-3-Clause
#include "common/ros2_bag_writer.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace slamfuse::common {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kCommitInterval{1};
constexpr int kMetadataVersion = 5;

constexpr const char* kTables =
    "PRAGMA journal_mode=TRUNCATE;"
    "PRAGMA synchronous=NORMAL;"
    "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
    "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
    "data BLOB NOT NULL);"
    "CREATE INDEX timestamp_idx ON messages (timestamp ASC);";

struct DatabaseCloser {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct StatementCloser {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, StatementCloser>;

struct WrittenTopic {
  BagTopic topic;
  std::size_t messages = 0;
};

void emit_duration(YAML::Emitter& yaml, Nanoseconds duration) {
  yaml << YAML::Key << "duration" << YAML::Value << YAML::BeginMap << YAML::Key << "nanoseconds" << YAML::Value
       << duration << YAML::EndMap;
}

void emit_start(YAML::Emitter& yaml, Nanoseconds start) {
  yaml << YAML::Key << "starting_time" << YAML::Value << YAML::BeginMap << YAML::Key << "nanoseconds_since_epoch"
       << YAML::Value << start << YAML::EndMap;
}

void emit_topic(YAML::Emitter& yaml, const WrittenTopic& written) {
  yaml << YAML::BeginMap << YAML::Key << "topic_metadata" << YAML::Value << YAML::BeginMap;
  yaml << YAML::Key << "name" << YAML::Value << written.topic.name;
  yaml << YAML::Key << "type" << YAML::Value << written.topic.type;
  yaml << YAML::Key << "serialization_format" << YAML::Value << "cdr";
  yaml << YAML::Key << "offered_qos_profiles" << YAML::Value << YAML::DoubleQuoted << written.topic.qos_profiles;
  yaml << YAML::EndMap << YAML::Key << "message_count" << YAML::Value << written.messages << YAML::EndMap;
}

}  // namespace

struct Ros2BagWriter::State {
  fs::path folder;
  std::string file;  // the database's name in the folder
  std::unique_ptr<sqlite3, DatabaseCloser> database = nullptr;
  Statement insert = nullptr;  // before the database goes
  std::vector<WrittenTopic> topics = {};
  std::size_t messages = 0;
  std::optional<Nanoseconds> first = std::nullopt;
  Nanoseconds last = 0;
  Clock::time_point committed = Clock::now();
  bool open = false;

  tl::unexpected<Error> broken() const {
    return failed((folder / file).string() + ": cannot be written: " + sqlite3_errmsg(database.get()));
  }

  Result<void> execute(const char* sql) const {
    if (sqlite3_exec(database.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return broken();
    return {};
  }

  std::string metadata() const {
    const Nanoseconds duration = first ? last - *first : 0;
    YAML::Emitter yaml;
    yaml << YAML::BeginMap << YAML::Key << "rosbag2_bagfile_information" << YAML::Value << YAML::BeginMap;
    yaml << YAML::Key << "version" << YAML::Value << kMetadataVersion;
    yaml << YAML::Key << "storage_identifier" << YAML::Value << "sqlite3";
    emit_duration(yaml, duration);
    emit_start(yaml, first.value_or(0));
    yaml << YAML::Key << "message_count" << YAML::Value << messages;
    yaml << YAML::Key << "topics_with_message_count" << YAML::Value << YAML::BeginSeq;
    for (const auto& topic : topics) emit_topic(yaml, topic);
    yaml << YAML::EndSeq;
    yaml << YAML::Key << "compression_format" << YAML::Value << YAML::DoubleQuoted << "";
    yaml << YAML::Key << "compression_mode" << YAML::Value << YAML::DoubleQuoted << "";
    yaml << YAML::Key << "relative_file_paths" << YAML::Value << YAML::BeginSeq << file << YAML::EndSeq;
    yaml << YAML::Key << "files" << YAML::Value << YAML::BeginSeq << YAML::BeginMap;
    yaml << YAML::Key << "path" << YAML::Value << file;
    emit_start(yaml, first.value_or(0));
    emit_duration(yaml, duration);
    yaml << YAML::Key << "message_count" << YAML::Value << messages;
    yaml << YAML::EndMap << YAML::EndSeq << YAML::EndMap << YAML::EndMap;
    return std::string(yaml.c_str()) + "\n";
  }
};

Result<std::unique_ptr<Ros2BagWriter>> Ros2BagWriter::create(const fs::path& folder) {
  std::error_code code;
  if (fs::exists(folder, code)) return usage_error(folder.string() + ": exists already, a bag is not written over");
  if (!fs::create_directories(folder, code)) {
    return invalid_input(folder.string() + ": cannot be made: " + code.message());
  }
  const fs::path named = folder.filename().empty() ? folder.parent_path() : folder;
  auto state = std::make_unique<State>(State{.folder = folder, .file = named.filename().string() + "_0.db3"});
  sqlite3* database = nullptr;
  const int opened = sqlite3_open((folder / state->file).c_str(), &database);
  state->database.reset(database);
  if (opened != SQLITE_OK) {
    return invalid_input((folder / state->file).string() + ": cannot be made: " + sqlite3_errstr(opened));
  }
  if (auto made = state->execute(kTables); !made) return tl::unexpected(made.error());
  sqlite3_stmt* insert = nullptr;
  if (sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert,
                         nullptr) != SQLITE_OK) {
    return state->broken();
  }
  state->insert.reset(insert);
  if (auto begun = state->execute("BEGIN"); !begun) return tl::unexpected(begun.error());
  state->open = true;
  return std::unique_ptr<Ros2BagWriter>(new Ros2BagWriter(std::move(state)));
}

Ros2BagWriter::Ros2BagWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}

Ros2BagWriter::~Ros2BagWriter() { static_cast<void>(close()); }

Result<std::size_t> Ros2BagWriter::add_topic(const BagTopic& topic) {
  State& s = *state_;
  sqlite3_stmt* statement = nullptr;
  const int prepared = sqlite3_prepare_v2(
      s.database.get(),
      "INSERT INTO topics(id, name, type, serialization_format, offered_qos_profiles) VALUES(?, ?, ?, 'cdr', ?)", -1,
      &statement, nullptr);
  const Statement insert(statement);
  if (prepared != SQLITE_OK) return s.broken();
  sqlite3_bind_int64(statement, 1, static_cast<sqlite3_int64>(s.topics.size()) + 1);
  sqlite3_bind_text(statement, 2, topic.name.c_str(), -1, SQLITE_STATIC);
  sqlite3_bind_text(statement, 3, topic.type.c_str(), -1, SQLITE_STATIC);
  sqlite3_bind_text(statement, 4, topic.qos_profiles.c_str(), -1, SQLITE_STATIC);
  if (sqlite3_step(statement) != SQLITE_DONE) return s.broken();
  s.topics.push_back({topic});
  return s.topics.size() - 1;
}

Result<void> Ros2BagWriter::write(std::size_t topic, Nanoseconds received, std::span<const std::uint8_t> data) {
  State& s = *state_;
  sqlite3_stmt* const insert = s.insert.get();
  sqlite3_reset(insert);
  sqlite3_bind_int64(insert, 1, static_cast<sqlite3_int64>(topic) + 1);
  sqlite3_bind_int64(insert, 2, received);
  sqlite3_bind_blob64(insert, 3, data.data(), data.size(), SQLITE_STATIC);
  if (sqlite3_step(insert) != SQLITE_DONE) return s.broken();
  ++s.topics[topic].messages;
  ++s.messages;
  s.first = std::min(s.first.value_or(received), received);
  s.last = s.messages == 1 ? received : std::max(s.last, received);
  if (Clock::now() - s.committed < kCommitInterval) return {};
  s.committed = Clock::now();
  sqlite3_reset(insert);
  return s.execute("COMMIT; BEGIN");
}

Result<void> Ros2BagWriter::close() {
  State& s = *state_;
  if (!std::exchange(s.open, false)) return {};
  sqlite3_reset(s.insert.get());
  if (auto done = s.execute("COMMIT"); !done) return done;
  const fs::path path = s.folder / "metadata.yaml";
  std::ofstream metadata(path, std::ios::binary);
  metadata << s.metadata();
  metadata.close();
  if (!metadata) return failed(path.string() + ": cannot be written");
  return {};
}

std::size_t Ros2BagWriter::messages() const { return state_->messages; }

}  // namespace slamfuse::common
