// isolux sweep scene.obj --accuracies 0.2,0.1,0.05,0.02,0.01 [--methods M,M,…] [--workers N]
//              [--reference room.ply|points.csv] [--points N] [-o sweep.csv|.html|.json] [--json]
//              [solve and import flags]
//
// What accuracy costs in time, by measurement: solves the scene at each accuracy with a coordinator
// and workers of its own, and measures the true error of each run against a reference: a patch
// file, values known at points, or a run at half of the finest accuracy with samples of its own.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <variant>

#include "client/commands/commands.h"
#include "client/commands/job_flags.h"
#include "client/local_cluster.h"
#include "client/sweep.h"
#include "client/web/page.h"
#include "common/util/file.h"

namespace isolux {
namespace {

constexpr size_t kMostRuns = 256;
// A reference may take this many times the budgets of the runs.
constexpr double kReferenceBudget = 4;
// A reference whose own error is above this share of a run's cannot tell what that run's is.
constexpr double kGoodReference = 0.7;

struct SweepFlags {
  std::string scene, output, reference;
  std::vector<double> accuracies{0.2, 0.1, 0.05, 0.02, 0.01};
  std::vector<std::string> methods;
  ComparisonOptions comparison;
  LocalCluster::Options cluster;
  ImportOptions import;
  SolveOptions solve;
  bool json = false;
};

enum class Format { kCsv, kJson, kHtml };

Result<Format> FormatOf(const std::string& output) {
  const std::string extension = std::filesystem::path(output).extension().string();
  if (extension == ".csv" || output.empty()) return Format::kCsv;
  if (extension == ".json") return Format::kJson;
  if (extension == ".html") return Format::kHtml;
  return Error(StatusCode::kInvalidArgument,
               "{}: what is measured is written as .csv, .json or .html", output);
}

// What the true error is measured by.
using Reference = std::variant<PatchFile, std::vector<ReferencePoint>>;

double EstimateOf(const PatchFile& file) {
  return std::strtod(file.Comment("error_estimate").c_str(), nullptr);
}

Result<Reference> ReadReference(const std::string& path, const std::string& scene,
                                const std::string& scene_hash) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (extension == ".csv") {
    ASSIGN_OR_RETURN(auto points, ReadReferencePoints(path));
    return Reference(std::move(points));
  }
  if (extension != ".ply") {
    return Error(StatusCode::kInvalidArgument,
                 "{}: a reference is a patch file (.ply) or points with known irradiance (.csv)",
                 path);
  }
  ASSIGN_OR_RETURN(auto file, ReadPatchFile(path));
  if (const std::string hash = file.Comment("scene_hash"); hash != scene_hash) {
    return Error(StatusCode::kInvalidArgument,
                 "{}: solves another scene (scene_hash {}) than {} as it is imported now ({}); "
                 "solve this one with the same import flags, or leave --reference out",
                 path, hash.empty() ? "not given" : hash, scene, scene_hash);
  }
  return Reference(std::move(file));
}

Result<Comparison> Measure(const PatchFile& file, const Reference& reference,
                           const ComparisonOptions& options) {
  if (const auto* better = std::get_if<PatchFile>(&reference)) {
    return Compare(file, *better, options);
  }
  return Compare(file, std::get<std::vector<ReferencePoint>>(reference));
}

// All that went between coordinator and workers, as the patch file has it by phases.
uint64_t TrafficBytes(const PatchFile& file) {
  uint64_t bytes = 0;
  for (const auto& [key, value] : file.comments) {
    if (key != "traffic") continue;
    for (const char* name : {" bytes_in ", " bytes_out "}) {
      const size_t at = value.find(name);
      if (at != std::string::npos) {
        bytes += std::strtoull(value.c_str() + at + std::strlen(name), nullptr, 10);
      }
    }
  }
  return bytes;
}

SweepRun Describe(const JobInfo& job, const std::string& method) {
  SweepRun run;
  run.method = method;
  run.accuracy = job.options.accuracy;
  run.seconds = job.summary.seconds;
  run.rounds = job.summary.rounds.size();
  run.rays = job.summary.rays;
  run.ended_by = ToText(job.summary.end_reason);
  if (job.summary.rounds.empty()) return run;
  const RoundSummary& last = job.summary.rounds.back();
  run.links = last.links;
  run.elements = last.elements;
  run.error_estimate = last.error_estimate;
  run.memory_bytes = last.memory_bytes;
  return run;
}

// The runs, one after the other on one cluster; their patch files stay in a folder until all are
// measured.
class Sweeper {
 public:
  Sweeper(const SweepFlags& options, Client::Submission submission, Client& client,
          const TemporaryDirectory& folder)
      : options_(options), submission_(std::move(submission)), client_(client), folder_(folder) {}

  Result<Sweep> Run(const std::vector<SweepMethod>& methods, std::optional<Reference> reference) {
    Sweep sweep;
    sweep.scene = submission_.name;
    sweep.workers = static_cast<uint32_t>(options_.cluster.workers);
    for (const SweepMethod& method : methods) {
      for (const double accuracy : options_.accuracies) {
        std::fprintf(stderr, "%s at %g %%\n", method.name.c_str(), 100 * accuracy);
        SolveOptions solve = options_.solve;
        solve.accuracy = accuracy;
        method.Apply(&solve);
        ASSIGN_OR_RETURN(const JobInfo job, Solve(solve, PathOf(sweep.runs.size())));
        sweep.runs.push_back(Describe(job, method.name));
      }
    }
    if (reference) {
      sweep.reference = std::filesystem::path(options_.reference).filename().string();
    } else {
      ASSIGN_OR_RETURN(reference, SolveReference(methods.front()));
      sweep.reference = fmt::format("a run at {:g} %", 50 * options_.accuracies.back());
    }
    if (const auto* file = std::get_if<PatchFile>(&*reference)) {
      sweep.reference_error = EstimateOf(*file);
      sweep.reference += fmt::format(", estimated to be off by {:.2g} %", 100 * EstimateOf(*file));
    }
    for (size_t i = 0; i < sweep.runs.size(); ++i) {
      RETURN_IF_ERROR(MeasureRun(PathOf(i), *reference, &sweep.runs[i], &sweep.points));
    }
    WarnOfReference(sweep);
    return sweep;
  }

 private:
  std::string PathOf(size_t run) const { return fmt::format("{}/{}.ply", folder_.path(), run); }

  Result<JobInfo> Solve(const SolveOptions& solve, const std::string& path) {
    submission_.options = solve;
    submission_.request_id = MakeRequestId();
    ASSIGN_OR_RETURN(const auto submitted, client_.Submit(submission_));
    ASSIGN_OR_RETURN(auto job, WatchWithProgress(client_, submitted.job, solve.accuracy));
    if (job.state != JobState::kDone) {
      return Error(StatusCode::kAborted, "the run at {:g} % {}: {}", 100 * solve.accuracy,
                   ToText(job.state), job.error.ok() ? job.message : job.error.message());
    }
    RETURN_IF_ERROR(client_.Fetch(job.id, path));
    return job;
  }

  Result<Reference> SolveReference(const SweepMethod& method) {
    SolveOptions solve = options_.solve;
    method.Apply(&solve);
    solve.accuracy = 0.5 * options_.accuracies.back();
    solve.max_seconds *= kReferenceBudget;
    solve.max_links =
        static_cast<uint64_t>(kReferenceBudget * static_cast<double>(solve.max_links));
    ++solve.seed;  // no error of a run's samples is to hide in the same of the reference
    std::fprintf(stderr, "reference at %g %%\n", 100 * solve.accuracy);
    const std::string path = folder_.path() + "/reference.ply";
    ASSIGN_OR_RETURN(const JobInfo job, Solve(solve, path));
    ASSIGN_OR_RETURN(auto file, ReadPatchFile(path));
    return Reference(std::move(file));
  }

  Status MeasureRun(const std::string& path, const Reference& reference, SweepRun* run,
                    uint64_t* points) {
    ASSIGN_OR_RETURN(const PatchFile file, ReadPatchFile(path));
    ASSIGN_OR_RETURN(const Comparison found, Measure(file, reference, options_.comparison));
    run->error_true = found.l1_relative;
    run->error_rms = found.rms_relative;
    run->error_p95 = found.p95_local;
    run->error_bias = found.bias_relative;
    run->bytes = TrafficBytes(file);
    *points = found.samples;
    return {};
  }

  static void WarnOfReference(const Sweep& sweep) {
    for (const SweepRun& run : sweep.runs) {
      if (sweep.reference_error <= kGoodReference * run.error_estimate) continue;
      std::fprintf(
          stderr,
          "isolux sweep: the reference's own error (%.2g %%) is not far below that of the "
          "run at %g %% (%.2g %%); give a better one with --reference, or larger budgets\n",
          100 * sweep.reference_error, 100 * run.accuracy, 100 * run.error_estimate);
    }
  }

  const SweepFlags& options_;
  Client::Submission submission_;
  Client& client_;
  const TemporaryDirectory& folder_;
};

Status CheckAccuracies(std::vector<double>* accuracies, size_t methods) {
  if (accuracies->size() * methods > kMostRuns) {
    return MakeStatus(StatusCode::kInvalidArgument, "{} runs are too many; the limit is {}",
                      accuracies->size() * methods, kMostRuns);
  }
  std::sort(accuracies->begin(), accuracies->end(), std::greater<>());
  accuracies->erase(std::unique(accuracies->begin(), accuracies->end()), accuracies->end());
  for (const double accuracy : *accuracies) {
    SolveOptions solve;
    solve.accuracy = accuracy;
    RETURN_IF_ERROR(solve.Validate());
  }
  return {};
}

Result<Sweep> SolveAll(const SweepFlags& options, const std::vector<SweepMethod>& methods,
                       Client::Submission submission, std::optional<Reference> reference,
                       Interruption& interruption) {
  ASSIGN_OR_RETURN(const auto folder, TemporaryDirectory::Make("isolux-sweep-"));
  ASSIGN_OR_RETURN(const auto cluster, LocalCluster::Start(options.cluster));
  Client& client = cluster->client();
  interruption.Set([&client] { client.Interrupt(); });
  // The client goes with the cluster; nobody may interrupt it then.
  struct Unset {
    Interruption* interruption;
    ~Unset() { interruption->Set(nullptr); }
  } unset{&interruption};
  Sweeper sweeper(options, std::move(submission), client, folder);
  return sweeper.Run(methods, std::move(reference));
}

std::string TextOf(const Sweep& sweep, Format format) {
  switch (format) {
    case Format::kJson:
      return ToJson(sweep).dump() + "\n";
    case Format::kHtml:
      return MakePage(PageKind::kSweep, "Sweep of " + sweep.scene, ToJson(sweep));
    default:
      return ToCsv(sweep);
  }
}

Status Write(const Sweep& sweep, Format format, const SweepFlags& options) {
  if (options.json) std::printf("%s\n", ToJson(sweep).dump().c_str());
  const std::string text = TextOf(sweep, format);
  if (!options.output.empty()) return WriteFileDurably(options.output, text);
  if (!options.json) std::printf("%s", text.c_str());
  return {};
}

int RunSweep(SweepFlags options) {
  const auto format = FormatOf(options.output);
  if (!format) return Fail("sweep", format.error());
  std::vector<SweepMethod> methods;
  for (const std::string& text : options.methods) {
    auto method = ParseSweepMethod(text);
    if (!method) return Fail("sweep", method.error());
    methods.push_back(std::move(*method));
  }
  if (methods.empty()) methods.emplace_back();
  if (const Status status = CheckAccuracies(&options.accuracies, methods.size()); !status.ok()) {
    return Fail("sweep", status);
  }
  auto submission = Prepare(options.scene, options.import, options.solve);
  if (!submission) return Fail("sweep", submission.error());
  std::optional<Reference> reference;
  if (!options.reference.empty()) {
    auto read = ReadReference(options.reference, options.scene, HashOf(submission->encoded_scene));
    if (!read) return Fail("sweep", read.error());
    reference = std::move(*read);
  }
  Interruption interruption;
  const Result<Sweep> sweep =
      SolveAll(options, methods, std::move(*submission), std::move(reference), interruption);
  if (interruption.happened()) {
    std::fprintf(stderr, "isolux sweep: interrupted\n");
    return kExitInterrupted;
  }
  if (!sweep) return Fail("sweep", sweep.error());
  std::fprintf(stderr, "%s", ToTable(*sweep).c_str());
  const Status written = Write(*sweep, *format, options);
  return written.ok() ? 0 : Fail("sweep", written);
}

}  // namespace

void AddSweepCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<SweepFlags>();
  options->comparison.samples = 1 << 16;
  CLI::App* command =
      app.add_subcommand("sweep", "what accuracy costs in time, by measurement, on this machine");
  command->add_option("scene", options->scene, "scene file (.obj, .gltf, .glb)")->required();
  command->add_option("--accuracies", options->accuracies, "to solve to, separated by commas")
      ->delimiter(',')
      ->capture_default_str();
  command
      ->add_option("--methods", options->methods,
                   "to compare, separated by commas: solvers, balance strategies, distributions, "
                   "or several joined by '+' (cg, jacobi+rotate) [the defaults]")
      ->delimiter(',');
  command->add_option("--reference", options->reference,
                      "what the true error is measured by: patch file (.ply) or points with known "
                      "irradiance (.csv) [a run at half of the finest accuracy]");
  command
      ->add_option("--points", options->comparison.samples,
                   "at which the true error is measured against a patch file")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1} << 28))
      ->capture_default_str();
  command->add_option(
      "-o,--output", options->output,
      "what is measured: .csv, .json, or .html, a page with charts [CSV on standard output]");
  command->add_flag("--json", options->json, "print one JSON object");
  AddClusterFlags(*command, &options->cluster);
  AddEffortFlags(*command, &options->solve);
  AddImportFlags(*command, &options->import);
  command->callback([options, &run] { run = [options] { return RunSweep(*options); }; });
}

}  // namespace isolux
