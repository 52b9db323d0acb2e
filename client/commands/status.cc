// isolux status JOB [--json] [--server HOST:PORT]
//
// How a job stands.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"

namespace isolux {
namespace {

struct StatusFlags {
  std::string server;
  uint64_t job = 0;
  bool json = false;
};

int RunStatus(const StatusFlags& options) {
  auto client = Client::Make(options.server);
  if (!client) return Fail("status", client.error());
  const Result<JobInfo> job = (*client)->Get(options.job);
  if (!job) return Fail("status", job.error());
  const std::string text = options.json ? ToJson(*job).dump() + "\n" : Describe(*job);
  std::fputs(text.c_str(), stdout);
  return 0;
}

}  // namespace

void AddStatusCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<StatusFlags>();
  CLI::App* command = app.add_subcommand("status", "show how a job stands");
  command->add_option("job", options->job, "number of the job")->required();
  command->add_flag("--json", options->json, "print one JSON object");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunStatus(*options); }; });
}

}  // namespace isolux
