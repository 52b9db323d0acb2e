// isolux: the command line. Each subcommand has a file of its own in commands/.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "client/commands/commands.h"
#include "common/util/build_info.h"

namespace isolux {
namespace {

constexpr int kUsage = 2;  // bad usage or bad input

int Main(int argc, char** argv) {
  CLI::App app("Isolux: diffuse light in polygon scenes, solved by hierarchical radiosity.",
               "isolux");
  app.set_version_flag("--version", BuildId());
  app.require_subcommand(1);
  Run run;
  AddSolveCommand(app, run);
  AddSubmitCommand(app, run);
  AddJobsCommand(app, run);
  AddStatusCommand(app, run);
  AddWatchCommand(app, run);
  AddCancelCommand(app, run);
  AddFinishCommand(app, run);
  AddFetchCommand(app, run);
  AddInspectCommand(app, run, MeasureCost);
  AddFactorsCommand(app, run);
  AddRenderCommand(app, run);
  AddCompareCommand(app, run);
  AddSweepCommand(app, run);
  AddReportCommand(app, run);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  const Status processor = CheckProcessor();
  if (!processor.ok()) {
    std::fprintf(stderr, "isolux: %s\n", processor.message().c_str());
    return 1;
  }
  return run();
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
