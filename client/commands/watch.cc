// isolux watch JOB [--json] [--server HOST:PORT]
//
// Follows a job to its end. The exit code is 0 where the job is done, 1 where it failed or was
// cancelled.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"

namespace isolux {
namespace {

struct WatchFlags {
  std::string server;
  uint64_t job = 0;
  bool json = false;
};

int RunWatch(const WatchFlags& options) {
  Interruption interruption;
  auto client = Client::Make(options.server);
  if (!client) return Fail("watch", client.error());
  interruption.Set([&client] { (*client)->Interrupt(); });
  const Result<JobInfo> before = (*client)->Get(options.job);
  const Result<JobInfo> job =
      before ? WatchWithProgress(**client, options.job, before->options.accuracy) : before;
  interruption.Set(nullptr);
  if (interruption.happened()) return kExitInterrupted;
  if (!job) return Fail("watch", job.error());
  std::fprintf(stderr, "%s\n", Summarize(*job).c_str());
  if (options.json) std::printf("%s\n", ToJson(*job).dump().c_str());
  return ExitCode(*job);
}

}  // namespace

void AddWatchCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<WatchFlags>();
  CLI::App* command = app.add_subcommand("watch", "follow a job to its end");
  command->add_option("job", options->job, "number of the job")->required();
  command->add_flag("--json", options->json, "print one JSON object at the end");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunWatch(*options); }; });
}

}  // namespace isolux
