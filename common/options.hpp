// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace slamfuse::common {

/// Visits the fields of an options struct. Every options struct declares its fields exactly once, in a method
/// `void describe(OptionVisitor& visit)`, with name, unit, allowed range and meaning; the default is the member
/// initialiser. Reading YAML, writing annotated YAML, `--help` and the README tables are all visitors, so none of them
/// can disagree.
///
///     struct GridOptions {
///       double resolution = 0.05;
///       void describe(OptionVisitor& visit) {
///         visit.real("resolution", resolution, {0.005, 1.0}, "m", "Side of a map cell.");
///       }
///     };
class OptionVisitor {
 public:
  /// An allowed range, both ends included.
  template <class T>
  struct Range {
    T min;
    T max;
  };

  virtual ~OptionVisitor() = default;

  virtual void real(const std::string& name, double& value, Range<double> range, const std::string& unit,
                    const std::string& meaning) = 0;
  virtual void integer(const std::string& name, int& value, Range<int> range, const std::string& unit,
                       const std::string& meaning) = 0;
  virtual void flag(const std::string& name, bool& value, const std::string& meaning) = 0;
  /// Any text on one line, such as a path; may be empty.
  virtual void text(const std::string& name, std::string& value, const std::string& meaning) = 0;
  /// `index` is the position of the chosen word in `words`.
  virtual void choice_index(const std::string& name, std::size_t& index, const std::vector<std::string>& words,
                            const std::string& meaning) = 0;
  /// A group of options under one key; `describe_fields` visits them.
  virtual void section(const std::string& name, const std::string& meaning,
                       const std::function<void(OptionVisitor&)>& describe_fields) = 0;

  /// One of an enum's values, by word. A value that is not listed is a programmer's mistake and becomes the first.
  template <class Enum>
  void choice(const std::string& name, Enum& value, const std::vector<std::pair<std::string, Enum>>& choices,
              const std::string& meaning) {
    std::vector<std::string> words;
    std::size_t index = 0;
    for (std::size_t i = 0; i < choices.size(); ++i) {
      words.push_back(choices[i].first);
      if (choices[i].second == value) index = i;
    }
    choice_index(name, index, words, meaning);
    value = choices[index].second;
  }

  /// A nested options struct.
  template <class Options>
  void nested(const std::string& name, Options& options, const std::string& meaning) {
    section(name, meaning, [&options](OptionVisitor& visit) { options.describe(visit); });
  }
};

}  // namespace slamfuse::common
