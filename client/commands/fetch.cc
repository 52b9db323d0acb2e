// isolux fetch JOB -o room.ply [--latest] [--server HOST:PORT]
//
// Brings the patch file of a job that is done; with --latest of one that still runs, as its newest
// round has it.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "common/scene/patch_file.h"

namespace isolux {
namespace {

struct FetchFlags {
  std::string server;
  std::string output;
  uint64_t job = 0;
  bool latest = false;
};

int RunFetch(const FetchFlags& options) {
  Interruption interruption;
  auto client = Client::Make(options.server);
  if (!client) return Fail("fetch", client.error());
  interruption.Set([&client] { (*client)->Interrupt(); });
  const Status status = (*client)->Fetch(options.job, options.output, options.latest);
  interruption.Set(nullptr);
  if (interruption.happened()) return kExitInterrupted;
  if (!status.ok()) return Fail("fetch", status);
  std::fprintf(stderr, "wrote %s\n", options.output.c_str());
  if (!options.latest) return 0;
  const Result<PatchFile> file = ReadPatchFile(options.output);
  if (!file) return Fail("fetch", file.error());
  const std::string left_out = file->Comment("bands_left_out");
  if (!left_out.empty()) {
    std::fprintf(stderr, "without spectral bands, %s\n", left_out.c_str());
  }
  return 0;
}

}  // namespace

void AddFetchCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<FetchFlags>();
  CLI::App* command = app.add_subcommand("fetch", "bring the patch file of a job");
  command->add_option("job", options->job, "number of the job")->required();
  command->add_option("-o,--output", options->output, "patch file to write")->required();
  command->add_flag("--latest", options->latest,
                    "while the job runs, the newest round's solution, not gathered");
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunFetch(*options); }; });
}

}  // namespace isolux
