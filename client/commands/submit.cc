// isolux submit scene.obj [--wait] [-o room.ply] [--request-id ID] [--name NAME] [--json]
//               [--server HOST:PORT] [solve and import flags]
//
// Hands a scene to the coordinator and prints the job's number; with --wait follows the job to its
// end and fetches the patch file.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"

namespace isolux {
namespace {

struct SubmitFlags {
  std::string scene;
  std::string output;
  std::string request_id;
  std::string name;
  std::string server;
  ImportOptions import;
  SolveOptions solve;
  bool wait = false;
  bool json = false;
};

int Wait(Client& client, uint64_t id, const SubmitFlags& options, Interruption& interruption) {
  const Result<JobInfo> job = WatchWithProgress(client, id, options.solve.accuracy);
  if (interruption.happened()) {
    std::fprintf(stderr, "job %lu goes on: isolux watch %lu, or isolux cancel %lu\n", id, id, id);
    return kExitInterrupted;
  }
  if (!job) return Fail("submit", job.error());
  Status fetched;
  if (job->state == JobState::kDone && !options.output.empty()) {
    fetched = client.Fetch(id, options.output);
  }
  std::fprintf(stderr, "%s\n", Summarize(*job).c_str());
  if (options.json) {
    nlohmann::json json = ToJson(*job);
    if (!options.output.empty()) json["output"] = options.output;
    std::printf("%s\n", json.dump().c_str());
  }
  return fetched.ok() ? ExitCode(*job) : Fail("submit", fetched);
}

int RunSubmit(const SubmitFlags& options) {
  if (!options.output.empty() && !options.wait) {
    return Fail("submit", MakeStatus(StatusCode::kInvalidArgument,
                                     "-o needs --wait: without it there is nothing to fetch yet"));
  }
  auto submission = Prepare(options.scene, options.import, options.solve);
  if (!submission) return Fail("submit", submission.error());
  submission->request_id = options.request_id.empty() ? MakeRequestId() : options.request_id;
  if (!options.name.empty()) submission->name = options.name;
  Interruption interruption;
  auto client = Client::Make(options.server);
  if (!client) return Fail("submit", client.error());
  interruption.Set([&client] { (*client)->Interrupt(); });
  const auto submitted = (*client)->Submit(*submission);
  if (!submitted) {
    const int code = Fail("submit", submitted.error());
    if (submitted.error().code() == StatusCode::kUnavailable) {
      std::fprintf(stderr, "to try again without a second job: --request-id %s\n",
                   submission->request_id.c_str());
    }
    interruption.Set(nullptr);
    return code;
  }
  int code = 0;
  if (options.wait) {
    std::fprintf(stderr, "job %lu%s\n", submitted->job,
                 submitted->existing ? " (handed in before)" : "");
    code = Wait(**client, submitted->job, options, interruption);
  } else if (options.json) {
    const nlohmann::json json = {{"job", submitted->job},
                                 {"existing", submitted->existing},
                                 {"request_id", submission->request_id}};
    std::printf("%s\n", json.dump().c_str());
  } else {
    std::printf("%lu\n", submitted->job);
  }
  interruption.Set(nullptr);
  return code;
}

}  // namespace

void AddSubmitCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<SubmitFlags>();
  CLI::App* command = app.add_subcommand("submit", "hand a scene to the coordinator");
  command->add_option("scene", options->scene, "scene file (.obj, .gltf, .glb)")->required();
  command->add_flag("--wait", options->wait, "follow the job to its end");
  command->add_option("-o,--output", options->output, "patch file to write, with --wait");
  command->add_option("--request-id", options->request_id,
                      "the same id again gives the same job, not another [a random one]");
  command->add_option("--name", options->name, "of the job [the file's name]");
  command->add_flag("--json", options->json, "print one JSON object");
  AddServerFlag(*command, &options->server);
  AddSolveFlags(*command, &options->solve);
  AddImportFlags(*command, &options->import);
  command->callback([options, &run] { run = [options] { return RunSubmit(*options); }; });
}

}  // namespace isolux
