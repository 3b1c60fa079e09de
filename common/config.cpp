// SPDX-License-Identifier: BSD-3-Clause
#include "common/config.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/config_node.hpp"
#include "common/option_range.hpp"
#include "common/text_fields.hpp"

namespace slamfuse::common {
namespace {

/// How many single-letter changes turn one word into the other (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::vector<std::string> nearest_first(std::vector<std::string> words, std::string_view to) {
  std::stable_sort(words.begin(), words.end(),
                   [&](const auto& a, const auto& b) { return edit_distance(a, to) < edit_distance(b, to); });
  return words;
}

/// A value as the user wrote it, for messages.
std::string shown(const ConfigNode& node) {
  switch (node.kind) {
    case ConfigNode::Kind::kNothing:
      return "empty";
    case ConfigNode::Kind::kScalar:
      return in_quotes(node.text);
    case ConfigNode::Kind::kList:
      return "a list";
    case ConfigNode::Kind::kMap:
      return "a group of keys";
  }
  return {};
}

/// Whether a reader only looks for mistakes or also changes the options.
enum class Pass { kCheck, kApply };

/// Compares one map of the tree with the options described for it.
class OptionReader : public OptionVisitor {
 public:
  OptionReader(const ConfigNode& map, std::string prefix, Pass pass, std::vector<std::string>& mistakes)
      : map_(map), prefix_(std::move(prefix)), pass_(pass), mistakes_(mistakes) {}

  void real(const std::string& name, double& value, Range<double> range, const std::string& unit,
            const std::string&) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    const std::optional<double> number = is_bare(*node) ? parse_real(node->text) : std::nullopt;
    if (!number || *number < range.min || *number > range.max) {
      return refuse(name, *node, "a number, " + range_text(range, unit));
    }
    if (pass_ == Pass::kApply) value = *number;
  }

  void integer(const std::string& name, int& value, Range<int> range, const std::string& unit,
               const std::string&) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    const std::optional<std::int64_t> number = is_bare(*node) ? parse_integer(node->text) : std::nullopt;
    if (!number || *number < range.min || *number > range.max) {
      return refuse(name, *node, "a whole number, " + range_text(range, unit));
    }
    if (pass_ == Pass::kApply) value = static_cast<int>(*number);
  }

  void flag(const std::string& name, bool& value, const std::string&) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    const bool yes = is_bare(*node) && node->text == "true";
    const bool no = is_bare(*node) && node->text == "false";
    if (!yes && !no) return refuse(name, *node, "true or false");
    if (pass_ == Pass::kApply) value = yes;
  }

  void text(const std::string& name, std::string& value, const std::string&) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    if (node->kind != ConfigNode::Kind::kScalar || node->text.find_first_of("\n\r") != std::string::npos) {
      return refuse(name, *node, "text on one line (\"\" for none)");
    }
    if (pass_ == Pass::kApply) value = node->text;
  }

  void choice_index(const std::string& name, std::size_t& index, const std::vector<std::string>& words,
                    const std::string&) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    const auto word =
        node->kind == ConfigNode::Kind::kScalar ? std::find(words.begin(), words.end(), node->text) : words.end();
    if (word == words.end()) {
      return refuse(name, *node, fmt::format("one of {}", fmt::join(nearest_first(words, node->text), ", ")));
    }
    if (pass_ == Pass::kApply) index = static_cast<std::size_t>(word - words.begin());
  }

  void section(const std::string& name, const std::string&,
               const std::function<void(OptionVisitor&)>& describe_fields) override {
    const ConfigNode* node = find(name);
    if (node == nullptr) return;
    if (node->kind != ConfigNode::Kind::kMap) return refuse(name, *node, "a group of keys");
    OptionReader reader(*node, prefix_ + name + ".", pass_, mistakes_);
    describe_fields(reader);
    reader.refuse_unknown();
  }

  /// To be called after all options have been visited.
  void refuse_unknown() {
    for (const ConfigEntry& entry : map_.entries) {
      if (std::find(known_.begin(), known_.end(), entry.key) != known_.end()) continue;
      mistakes_.push_back(fmt::format("{}: unknown key {}, allowed here: {}", entry.where,
                                      in_quotes(prefix_ + entry.key),
                                      fmt::join(nearest_first(known_, entry.key), ", ")));
    }
  }

 private:
  static bool is_bare(const ConfigNode& node) { return node.kind == ConfigNode::Kind::kScalar && !node.was_quoted; }

  const ConfigNode* find(const std::string& name) {
    known_.push_back(name);
    const auto entry =
        std::find_if(map_.entries.begin(), map_.entries.end(), [&](const auto& e) { return e.key == name; });
    return entry == map_.entries.end() ? nullptr : &entry->value;
  }

  void refuse(const std::string& name, const ConfigNode& node, const std::string& allowed) {
    mistakes_.push_back(fmt::format("{}: {}{} is {}, expected {}", node.where, prefix_, name, shown(node), allowed));
  }

  const ConfigNode& map_;
  std::string prefix_;
  Pass pass_;
  std::vector<std::string>& mistakes_;
  std::vector<std::string> known_;
};

/// Everything is checked before anything is changed, so that an error leaves the options as they were.
Result<void> apply(const ConfigNode& root, const DescribeOptions& describe, ErrorKind kind) {
  std::vector<std::string> mistakes;
  for (const Pass pass : {Pass::kCheck, Pass::kApply}) {
    OptionReader reader(root, "", pass, mistakes);
    describe(reader);
    reader.refuse_unknown();
    if (!mistakes.empty()) return tl::unexpected(Error{kind, fmt::format("{}", fmt::join(mistakes, "\n"))});
  }
  return {};
}

}  // namespace

Result<void> read_options(const std::filesystem::path& yaml, const DescribeOptions& describe) {
  const Result<ConfigNode> root = read_config_tree(yaml);
  if (!root) return tl::unexpected(root.error());
  return apply(*root, describe, ErrorKind::kInvalidInput);
}

Result<void> set_option(std::string_view assignment, const DescribeOptions& describe) {
  const Result<ConfigNode> root = parse_assignment(assignment);
  if (!root) return tl::unexpected(root.error());
  return apply(*root, describe, ErrorKind::kUsage);
}

}  // namespace slamfuse::common
