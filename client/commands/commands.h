// The subcommands of `isolux`, one file each. AddX registers the command with its flags and, when
// it is the one given, leaves in `run` what main is to call; that returns the exit code (0 done, 1
// failed, 2 bad usage or bad input).
#pragma once

#include <functional>

#include "client/commands/cost.h"

namespace CLI {
class App;
}

namespace isolux {

using Run = std::function<int()>;

void AddSolveCommand(CLI::App& app, Run& run);
void AddSubmitCommand(CLI::App& app, Run& run);
void AddJobsCommand(CLI::App& app, Run& run);
void AddStatusCommand(CLI::App& app, Run& run);
void AddWatchCommand(CLI::App& app, Run& run);
void AddCancelCommand(CLI::App& app, Run& run);
void AddFinishCommand(CLI::App& app, Run& run);
void AddFetchCommand(CLI::App& app, Run& run);
// `measure_cost` runs a scene's first rounds, for --cost; without it there is no such flag.
void AddInspectCommand(CLI::App& app, Run& run, const CostFunction& measure_cost = {});
void AddFactorsCommand(CLI::App& app, Run& run);
void AddRenderCommand(CLI::App& app, Run& run);
void AddCompareCommand(CLI::App& app, Run& run);
void AddSweepCommand(CLI::App& app, Run& run);
void AddReportCommand(CLI::App& app, Run& run);

}  // namespace isolux
