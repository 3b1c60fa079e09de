// SPDX-License-Identifier: BSD-3-Clause
#include "common/config_node.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

/// Far above any real configuration, small enough that a hostile file costs nothing.
constexpr std::size_t kMaxBytes = std::size_t{256} * 1024;
constexpr std::size_t kMaxDepth = 16;
constexpr std::size_t kMaxKeysPerMap = 1000;

/// Builds the tree from yaml-cpp's events. Events rather than YAML::Node, because a Node has already lost repeated keys
/// and shares aliased parts. What it refuses it throws as YAML::ParserException, caught in read_config_tree().
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string file) : file_(std::move(file)) {}

  ConfigNode take_root() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ > 0) throw YAML::ParserException(mark, "a second document starts here, expected only one");
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    refuse_anchor(mark, anchor);
    close(mark, make(ConfigNode::Kind::kNothing, mark));
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { refuse_anchor(mark, 1); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    refuse_anchor(mark, anchor);
    // yaml-cpp tags plain scalars "?" and scalars in quotes "!".
    if (tag != "?" && tag != "!" && !tag.empty()) {
      throw YAML::ParserException(mark, "the tag " + in_quotes(tag) + " is not supported");
    }
    ConfigNode node = make(ConfigNode::Kind::kScalar, mark);
    node.text = value;
    node.was_quoted = tag == "!";
    close(mark, std::move(node));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, anchor, ConfigNode::Kind::kList);
  }
  void OnSequenceEnd() override { close_innermost(); }
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, anchor, ConfigNode::Kind::kMap);
  }
  void OnMapEnd() override { close_innermost(); }

  std::string where(const YAML::Mark& mark) const {
    return mark.is_null() ? file_ : fmt::format("{}:{}:{}", file_, mark.line + 1, mark.column + 1);
  }

 private:
  /// A list or map whose end has not come yet.
  struct Open {
    YAML::Mark mark;
    ConfigNode node;
    std::optional<ConfigEntry> entry;  ///< of a map: the key has been read, its value has not
  };

  static void refuse_anchor(const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (anchor != 0) throw YAML::ParserException(mark, "anchors and aliases are not supported");
  }

  ConfigNode make(ConfigNode::Kind kind, const YAML::Mark& mark) const {
    ConfigNode node;
    node.kind = kind;
    node.where = where(mark);
    return node;
  }

  void open(const YAML::Mark& mark, YAML::anchor_t anchor, ConfigNode::Kind kind) {
    refuse_anchor(mark, anchor);
    if (open_.size() >= kMaxDepth) {
      throw YAML::ParserException(mark, fmt::format("nested deeper than {} levels", kMaxDepth));
    }
    open_.push_back({mark, make(kind, mark), std::nullopt});
  }

  void close_innermost() {
    Open done = std::move(open_.back());
    open_.pop_back();
    close(done.mark, std::move(done.node));
  }

  /// A finished node goes where it belongs: root, key or value of the innermost map.
  void close(const YAML::Mark& mark, ConfigNode node) {
    if (open_.empty()) {
      root_ = std::move(node);
      return;
    }
    Open& parent = open_.back();
    if (parent.node.kind != ConfigNode::Kind::kMap) return;
    if (parent.entry) {
      parent.entry->value = std::move(node);
      parent.node.entries.push_back(std::move(*parent.entry));
      parent.entry.reset();
    } else {
      start_entry(mark, parent, node);
    }
  }

  static void start_entry(const YAML::Mark& mark, Open& map, const ConfigNode& key) {
    if (key.kind != ConfigNode::Kind::kScalar) throw YAML::ParserException(mark, "expected a word as key");
    for (const ConfigEntry& earlier : map.node.entries) {
      if (earlier.key == key.text) {
        throw YAML::ParserException(
            mark, fmt::format("the key {} is given twice, first at {}", in_quotes(key.text), earlier.where));
      }
    }
    if (map.node.entries.size() >= kMaxKeysPerMap) {
      throw YAML::ParserException(mark, fmt::format("more than {} keys", kMaxKeysPerMap));
    }
    map.entry = ConfigEntry{key.text, key.where, {}};
  }

  std::string file_;
  std::vector<Open> open_;
  ConfigNode root_;
  int documents_ = 0;
};

Result<std::string> read_small_file(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return invalid_input(fmt::format("{}: is a folder, expected a YAML file", path.string()));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return invalid_input(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  std::string text(kMaxBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (file.bad()) return invalid_input(fmt::format("{}: reading failed: {}", path.string(), std::strerror(errno)));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kMaxBytes) {
    return invalid_input(fmt::format("{}: larger than {} bytes, no configuration is", path.string(), kMaxBytes));
  }
  return text;
}

}  // namespace

Result<ConfigNode> read_config_tree(const std::filesystem::path& yaml) {
  const Result<std::string> text = read_small_file(yaml);
  if (!text) return tl::unexpected(text.error());

  TreeBuilder builder(yaml.string());
  try {
    std::istringstream stream(*text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const YAML::Exception& error) {
    return invalid_input(fmt::format("{}: {}", builder.where(error.mark), error.msg));
  } catch (const std::exception& error) {
    return invalid_input(fmt::format("{}: is no readable YAML: {}", yaml.string(), error.what()));
  }

  ConfigNode root = builder.take_root();
  if (root.kind == ConfigNode::Kind::kNothing) {
    return invalid_input(fmt::format("{}: is empty, expected at least one `key: value`", yaml.string()));
  }
  if (root.kind != ConfigNode::Kind::kMap) {
    return invalid_input(fmt::format("{}: expected `key: value` pairs at the outermost level", root.where));
  }
  return root;
}

Result<ConfigNode> parse_assignment(std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    return usage_error(fmt::format("{}: expected key=value, e.g. laser.particles=50", in_quotes(assignment)));
  }
  const std::string where = in_quotes(assignment);
  ConfigNode node;
  node.kind = ConfigNode::Kind::kScalar;
  node.where = where;
  node.text = assignment.substr(equals + 1);

  // From the innermost key outwards.
  std::string_view path = assignment.substr(0, equals);
  if (static_cast<std::size_t>(std::count(path.begin(), path.end(), '.')) >= kMaxDepth) {
    return usage_error(fmt::format("{}: the key has more than {} parts", where, kMaxDepth));
  }
  while (true) {
    const std::size_t dot = path.rfind('.');
    const std::string_view key = dot == std::string_view::npos ? path : path.substr(dot + 1);
    if (key.empty()) return usage_error(fmt::format("{}: a part of the key is empty", where));
    ConfigNode map;
    map.kind = ConfigNode::Kind::kMap;
    map.where = where;
    map.entries.push_back({std::string(key), where, std::move(node)});
    node = std::move(map);
    if (dot == std::string_view::npos) return node;
    path = path.substr(0, dot);
  }
}

}  // namespace slamfuse::common
