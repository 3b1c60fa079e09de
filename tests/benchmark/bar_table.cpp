// SPDX-License-Identifier: BSD-3-Clause
#include "benchmark/bar_table.hpp"

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace slamfuse {

void BarTable::print_head() const {
  print_row("what", "bar", "measured", "verdict");
  fmt::print("|{:-<62}|{:-<24}|{:-<42}|{:-<9}|\n", "", "", "", "");
}

void BarTable::judge(const std::string& name, const std::string& bar, const std::string& measured, bool pass) {
  if (!pass) ++failures_;
  print_row(name, bar, measured, pass ? "pass" : "FAIL");
}

void BarTable::at_most(const std::string& name, double measured, double bar) {
  judge(name, fmt::format("<= {}", bar), fmt::format("{:.4f}", measured), measured <= bar);
}

void BarTable::at_least(const std::string& name, double measured, double bar) {
  judge(name, fmt::format(">= {}", bar), fmt::format("{:.4f}", measured), measured >= bar);
}

int BarTable::exit_status() const { return failures_ == 0 ? EXIT_SUCCESS : EXIT_FAILURE; }

void BarTable::print_row(const std::string& name, const std::string& bar, const std::string& measured,
                         const char* verdict) const {
  fmt::print("| {:<60} | {:<22} | {:<40} | {:<7} |\n", name, bar, measured, verdict);
  std::fflush(stdout);
}

}  // namespace slamfuse
