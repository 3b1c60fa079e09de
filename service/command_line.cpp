// SPDX-License-Identifier: BSD-3-Clause
#include "service/command_line.hpp"

#include <CLI/CLI.hpp>

#include "service/file_flags.hpp"
#include "service/metrics.hpp"
#include "service/pipeline_flags.hpp"
#include "service/topic_flags.hpp"

namespace slamfuse::service {

using common::Result;

Result<CommandRequest> parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Laser and visual SLAM side by side, one trusted pose out.", "slamfuse");
  app.set_version_flag("--version", std::string("slamfuse ") + program_version());
  app.require_subcommand(1);
  RunFlags run(app);
  ServeFlags serve(app);
  PlayFlags play(app);
  RecordFlags record(app);
  CallFlags call(app);
  AlignFlags align(app);
  EvaluateFlags evaluate(app);
  InfoFlags info(app);
  OptionsFlags options(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    const auto chosen = app.get_subcommands();
    return PrintRequest{chosen.empty() ? app.help() : chosen.front()->help("slamfuse")};
  } catch (const CLI::CallForVersion& version) {
    return PrintRequest{std::string(version.what()) + "\n"};
  } catch (const CLI::Error& error) {
    return common::usage_error(std::string(error.what()) + "\nRun with --help for more information.");
  }
  if (run.chosen()) return run.request();
  if (serve.chosen()) return serve.request();
  if (play.chosen()) return play.request();
  if (record.chosen()) return record.request();
  if (call.chosen()) return call.request();
  if (align.chosen()) return align.request();
  if (evaluate.chosen()) return evaluate.request();
  if (info.chosen()) return info.request();
  return options.request();
}

}  // namespace slamfuse::service
