// isolux finish JOB [--json] [--server HOST:PORT]
//
// Ends the refinement of a job that runs and waits for its patch file: the round under way is the
// last. Of a job that is done nothing changes.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"

namespace isolux {
namespace {

struct FinishFlags {
  std::string server;
  uint64_t job = 0;
  bool json = false;
};

int RunFinish(const FinishFlags& options) {
  Interruption interruption;
  auto client = Client::Make(options.server);
  if (!client) return Fail("finish", client.error());
  interruption.Set([&client] { (*client)->Interrupt(); });
  const Result<JobState> state = (*client)->Finish(options.job);
  Result<JobInfo> job = state ? (*client)->Watch(options.job, Client::Watcher())
                              : Result<JobInfo>(tl::unexpected<Status>(state.error()));
  interruption.Set(nullptr);
  if (interruption.happened()) {
    std::fprintf(stderr, "job %lu finishes: isolux watch %lu\n", options.job, options.job);
    return kExitInterrupted;
  }
  if (!job) return Fail("finish", job.error());
  std::fprintf(stderr, "%s\n", Summarize(*job).c_str());
  if (options.json) {
    std::printf("%s\n", ToJson(*job).dump().c_str());
  } else {
    std::printf("job %lu %s\n", options.job, ToText(job->state));
  }
  return ExitCode(*job);
}

}  // namespace

void AddFinishCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<FinishFlags>();
  CLI::App* command =
      app.add_subcommand("finish", "end the refinement of a job and have what there is");
  command->add_option("job", options->job, "number of the job")->required();
  command->add_flag("--json", options->json, "print one JSON object");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunFinish(*options); }; });
}

}  // namespace isolux
