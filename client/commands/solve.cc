// isolux solve scene.obj [--workers N] [--threads N] [-o room.ply] [--json] [solve and import
// flags]
//
// All of it in one command: starts a coordinator and workers as child processes, hands in the
// scene, shows the progress, fetches the patch file, and takes everything down again.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"
#include "client/local_cluster.h"

namespace isolux {
namespace {

struct SolveFlags {
  std::string scene;
  std::string output;
  LocalCluster::Options cluster;
  ImportOptions import;
  SolveOptions solve;
  bool json = false;
};

Result<JobInfo> Solve(const SolveFlags& options, Client::Submission submission,
                      Interruption& interruption) {
  submission.request_id = MakeRequestId();
  ASSIGN_OR_RETURN(const auto cluster, LocalCluster::Start(options.cluster));
  Client& client = cluster->client();
  interruption.Set([&client] { client.Interrupt(); });
  // The client goes with the cluster; nobody may interrupt it then.
  struct Unset {
    Interruption* interruption;
    ~Unset() { interruption->Set(nullptr); }
  } unset{&interruption};
  ASSIGN_OR_RETURN(const auto submitted, client.Submit(submission));
  ASSIGN_OR_RETURN(auto job, WatchWithProgress(client, submitted.job, options.solve.accuracy));
  if (job.state == JobState::kDone) {
    RETURN_IF_ERROR(client.Fetch(job.id, options.output));
  }
  return job;
}

int RunSolve(SolveFlags options) {
  if (options.output.empty()) {
    options.output = std::filesystem::path(options.scene).stem().string() + ".ply";
  }
  auto submission = Prepare(options.scene, options.import, options.solve);
  if (!submission) return Fail("solve", submission.error());
  Interruption interruption;
  const Result<JobInfo> job = Solve(options, std::move(*submission), interruption);
  if (interruption.happened()) {
    std::fprintf(stderr, "isolux solve: interrupted\n");
    return kExitInterrupted;
  }
  if (!job) return Fail("solve", job.error());
  std::fprintf(stderr, "%s\n", Summarize(*job).c_str());
  if (options.json) {
    nlohmann::json json = ToJson(*job);
    json["output"] = options.output;
    std::printf("%s\n", json.dump().c_str());
  }
  if (job->state == JobState::kDone) std::fprintf(stderr, "wrote %s\n", options.output.c_str());
  return ExitCode(*job);
}

}  // namespace

void AddSolveCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<SolveFlags>();
  CLI::App* command = app.add_subcommand(
      "solve", "solve a scene with a coordinator and workers of its own, on this machine");
  command->add_option("scene", options->scene, "scene file (.obj, .gltf, .glb)")->required();
  command->add_option("-o,--output", options->output, "patch file to write [SCENE.ply]");
  AddClusterFlags(*command, &options->cluster);
  command->add_flag("--json", options->json, "print one JSON object");
  AddSolveFlags(*command, &options->solve);
  AddImportFlags(*command, &options->import);
  command->callback([options, &run] { run = [options] { return RunSolve(*options); }; });
}

}  // namespace isolux
