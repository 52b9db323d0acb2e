// isolux report J|room.ply -o report.html [--camera cam.json] [--up auto|y|z] [--server HOST:PORT]
//
// What a solve took and reached, as one HTML page: of a patch file, or of a job that is done, whose
// patch file is fetched for it.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "client/commands/camera_file.h"
#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/job_text.h"
#include "client/report/report.h"
#include "common/util/file.h"

namespace isolux {
namespace {

struct ReportFlags {
  std::string source, output, server, camera_file, up = "auto";
  int threads = 0;  // one a core
};

// The number of a job, or nothing where it is the name of a file.
std::optional<uint64_t> JobNumber(const std::string& source) {
  uint64_t job = 0;
  const auto [end, error] = std::from_chars(source.data(), source.data() + source.size(), job);
  if (error != std::errc() || end != source.data() + source.size()) return std::nullopt;
  return job;
}

// Of a job that is done; `report` learns what the coordinator knows of it.
Result<PatchFile> FetchPatchFile(Client& client, uint64_t job, ReportOptions* report) {
  ASSIGN_OR_RETURN(const JobInfo info, client.Get(job));
  if (info.state != JobState::kDone) {
    return Error(StatusCode::kFailedPrecondition,
                 "job {} is {}: there is nothing to report before it is done; 'isolux watch {}' "
                 "follows it",
                 job, ToText(info.state), job);
  }
  report->job = ToJson(info);
  report->name = info.name;
  ASSIGN_OR_RETURN(const auto folder, TemporaryDirectory::Make("isolux-report"));
  const std::string path = folder.path() + "/result.ply";
  RETURN_IF_ERROR(client.Fetch(job, path));
  return ReadPatchFile(path);
}

Status WriteReport(const ReportFlags& options, const PatchFile& file, const ReportOptions& report) {
  ThreadPool pool(options.threads);
  auto page = MakeReport(file, report, pool);
  if (!page) return page.error().Within(options.source);
  return WriteFileDurably(options.output, *page);
}

// The patch file of a job, or an error; `interrupted` when the user gave up.
Result<PatchFile> FetchFrom(const ReportFlags& options, uint64_t job, ReportOptions* report,
                            bool* interrupted) {
  Interruption interruption;
  ASSIGN_OR_RETURN(const auto client, Client::Make(options.server));
  interruption.Set([&client] { client->Interrupt(); });
  auto file = FetchPatchFile(*client, job, report);
  interruption.Set(nullptr);
  *interrupted = interruption.happened();
  return file;
}

Status Report(const ReportFlags& options, bool* interrupted) {
  ReportOptions report;
  report.up = options.up == "y" ? 1 : options.up == "z" ? 2 : 0;
  if (!options.camera_file.empty()) {
    ASSIGN_OR_RETURN(report.camera, ReadCameraOf(options.camera_file));
  }
  if (const auto job = JobNumber(options.source)) {
    ASSIGN_OR_RETURN(const PatchFile file, FetchFrom(options, *job, &report, interrupted));
    return WriteReport(options, file, report);
  }
  report.name = std::filesystem::path(options.source).filename().string();
  ASSIGN_OR_RETURN(const PatchFile file, ReadPatchFile(options.source));
  return WriteReport(options, file, report);
}

int RunReport(const ReportFlags& options) {
  bool interrupted = false;
  const Status status = Report(options, &interrupted);
  if (interrupted) return kExitInterrupted;
  if (!status.ok()) return Fail("report", status);
  std::fprintf(stderr, "wrote %s\n", options.output.c_str());
  return 0;
}

}  // namespace

void AddReportCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<ReportFlags>();
  CLI::App* command =
      app.add_subcommand("report", "what accuracy cost in a solve: one HTML page with charts");
  command
      ->add_option("job", options->source, "number of a job that is done, or a patch file (.ply)")
      ->required();
  command->add_option("-o,--output", options->output, "page to write (.html)")->required();
  command->add_option(
      "--camera", options->camera_file,
      "camera.json of the pictures, or a camera of a scene, FILE.gltf[:NUMBER|:NAME] "
      "(default: a view that shows much)");
  command->add_option("--up", options->up, "without a camera: which axis is up, y, z or auto")
      ->check(CLI::IsMember({"auto", "y", "z"}))
      ->capture_default_str();
  command->add_option("--threads", options->threads, "0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  AddServerFlag(*command, &options->server);
  command->callback([options, &run] { run = [options] { return RunReport(*options); }; });
}

}  // namespace isolux
