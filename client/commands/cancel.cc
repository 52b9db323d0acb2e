// isolux cancel JOB [--json] [--server HOST:PORT]
//
// Ends a job that is queued or running. Of a job that has ended nothing changes.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"

namespace isolux {
namespace {

struct CancelFlags {
  std::string server;
  uint64_t job = 0;
  bool json = false;
};

int RunCancel(const CancelFlags& options) {
  auto client = Client::Make(options.server);
  if (!client) return Fail("cancel", client.error());
  Result<JobState> state = (*client)->Cancel(options.job);
  if (state && !HasEnded(*state)) {
    // The workers have yet to stop.
    const Result<JobInfo> job = (*client)->Watch(options.job, Client::Watcher());
    if (!job) return Fail("cancel", job.error());
    state = job->state;
  }
  if (!state) return Fail("cancel", state.error());
  if (options.json) {
    const nlohmann::json json = {{"job", options.job}, {"state", ToText(*state)}};
    std::printf("%s\n", json.dump().c_str());
  } else {
    std::printf("job %lu %s\n", options.job, ToText(*state));
  }
  return 0;
}

}  // namespace

void AddCancelCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<CancelFlags>();
  CLI::App* command = app.add_subcommand("cancel", "end a job");
  command->add_option("job", options->job, "number of the job")->required();
  command->add_flag("--json", options->json, "print one JSON object");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunCancel(*options); }; });
}

}  // namespace isolux
