// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace slamfuse {

/// The table bar | measured | verdict of a benchmark, printed row by row as the figures come.
class BarTable {
 public:
  /// Only rows whose group contains `only` are wanted.
  explicit BarTable(std::string only) : only_(std::move(only)) {}

  bool wants(const std::string& group) const { return group.find(only_) != std::string::npos; }
  void print_head() const;
  /// A row without a bar.
  void show(const std::string& name, const std::string& measured) const { print_row(name, "(shown)", measured, ""); }
  void skip(const std::string& name, const std::string& why) const { print_row(name, "", why, "skipped"); }
  void judge(const std::string& name, const std::string& bar, const std::string& measured, bool pass);
  void at_most(const std::string& name, double measured, double bar);
  void at_least(const std::string& name, double measured, double bar);

  /// Of the process: failure if a bar was missed.
  int exit_status() const;

 private:
  void print_row(const std::string& name, const std::string& bar, const std::string& measured,
                 const char* verdict) const;

  std::string only_;
  int failures_ = 0;
};

}  // namespace slamfuse
