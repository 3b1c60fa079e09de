// SPDX-License-Identifier: BSD-3-Clause
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/config.hpp"
#include "common/option_range.hpp"

namespace slamfuse::common {
namespace {

/// One option, ready to print.
struct OptionLine {
  std::string value;
  std::string unit;
  std::string allowed;
  std::string meaning;
};

/// Text as YAML takes it back, whatever it holds.
std::string in_yaml_quotes(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + '"';
}

/// Turns every visited option into an OptionLine; the three formats differ in what they make of it.
class OptionPrinter : public OptionVisitor {
 public:
  void real(const std::string& name, double& value, Range<double> range, const std::string& unit,
            const std::string& meaning) override {
    print(name, {real_text(value), unit, range_text(range, unit), meaning});
  }
  void integer(const std::string& name, int& value, Range<int> range, const std::string& unit,
               const std::string& meaning) override {
    print(name, {std::to_string(value), unit, range_text(range, unit), meaning});
  }
  void flag(const std::string& name, bool& value, const std::string& meaning) override {
    print(name, {value ? "true" : "false", "", "true or false", meaning});
  }
  void text(const std::string& name, std::string& value, const std::string& meaning) override {
    print(name, {in_yaml_quotes(value), "", "any text", meaning});
  }
  void choice_index(const std::string& name, std::size_t& index, const std::vector<std::string>& words,
                    const std::string& meaning) override {
    print(name, {words.at(index), "", fmt::format("{}", fmt::join(words, ", ")), meaning});
  }
  void section(const std::string& name, const std::string& meaning,
               const std::function<void(OptionVisitor&)>& describe_fields) override {
    enter(name, meaning);
    path_.push_back(name);
    describe_fields(*this);
    path_.pop_back();
  }

  std::string text() const { return fmt::to_string(text_); }

 protected:
  virtual void print(const std::string& name, const OptionLine& option) = 0;
  virtual void enter(const std::string&, const std::string&) {}

  std::size_t depth() const { return path_.size(); }
  std::string dotted(const std::string& name) const {
    return path_.empty() ? name : fmt::format("{}.{}", fmt::join(path_, "."), name);
  }
  template <class... Args>
  void append(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }

 private:
  std::vector<std::string> path_;
  fmt::memory_buffer text_;
};

class YamlPrinter : public OptionPrinter {
  void print(const std::string& name, const OptionLine& option) override {
    append("{0}# {1} ({2})\n{0}{3}: {4}\n", indent(), option.meaning, option.allowed, name, option.value);
  }
  void enter(const std::string& name, const std::string& meaning) override {
    append("\n{0}# {1}\n{0}{2}:\n", indent(), meaning, name);
  }
  std::string indent() const { return std::string(2 * depth(), ' '); }
};

class MarkdownPrinter : public OptionPrinter {
 public:
  MarkdownPrinter() { append("| option | default | allowed | meaning |\n|---|---|---|---|\n"); }

 private:
  void print(const std::string& name, const OptionLine& option) override {
    append("| `{}` | {} | {} | {} |\n", dotted(name), option.value, escaped(option.allowed), escaped(option.meaning));
  }
  static std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
    return result;
  }
};

class HelpPrinter : public OptionPrinter {
  void print(const std::string& name, const OptionLine& option) override {
    append("  {}={}\n      {} ({})\n", dotted(name), option.value, option.meaning, option.allowed);
  }
};

template <class Printer>
std::string printed(const DescribeOptions& describe) {
  Printer printer;
  describe(printer);
  return printer.text();
}

}  // namespace

std::string options_to_yaml(const DescribeOptions& describe) { return printed<YamlPrinter>(describe); }
std::string options_to_markdown(const DescribeOptions& describe) { return printed<MarkdownPrinter>(describe); }
std::string options_to_help(const DescribeOptions& describe) { return printed<HelpPrinter>(describe); }

}  // namespace slamfuse::common
