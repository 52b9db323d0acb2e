// isolux factors scene.obj [--tolerance T] [-o F.csv|F.json] [--json] [--threads N]
//                          [--reflect front|both] [--emit front|both] [--unit m|cm|mm|in|ft]
//                          [--strict]
//
// Form factors past obstacles between the polygons of the file, each with an error, and their row
// sums. Fronts only unless both sides are asked for: docs/factors.md. Nothing needs to emit.
#include <strings.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "client/commands/commands.h"
#include "client/commands/factors_text.h"
#include "client/commands/fail.h"
#include "client/commands/import_flags.h"
#include "common/util/file.h"

namespace isolux {
namespace {

struct FactorsFlags {
  std::string scene, output;
  ImportOptions import;
  FactorOptions factors;
  int threads = 0;
  bool json = false;
};

enum class Format { kNone, kCsv, kJson };
Result<Format> FormatOf(const std::string& path) {
  if (path.empty()) return Format::kNone;
  const std::string extension = std::filesystem::path(path).extension().string();
  if (strcasecmp(extension.c_str(), ".csv") == 0) return Format::kCsv;
  if (strcasecmp(extension.c_str(), ".json") == 0) return Format::kJson;
  return Error(StatusCode::kInvalidArgument, "{}: '{}' is neither .csv nor .json", path, extension);
}

// F.csv → F.rows.csv
std::string RowsPath(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".rows.csv").string();
}

Status Write(const FactorsFlags& options, Format format, const FactorTable& table,
             const std::string& json) {
  if (format == Format::kJson) return WriteFileDurably(options.output, json);
  if (format == Format::kNone) return {};
  RETURN_IF_ERROR(WriteFileDurably(options.output, FactorsAsCsv(table)));
  return WriteFileDurably(RowsPath(options.output), RowsAsCsv(table));
}

// The share of pairs that are done, on standard error: a line that is redrawn on a terminal, one
// line in ten seconds elsewhere.
class Progress {
 public:
  Progress() : terminal_(isatty(STDERR_FILENO) != 0 && std::getenv("CI") == nullptr) {}

  void Show(double share) {
    const auto now = std::chrono::steady_clock::now();
    const auto pause = terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10);
    if (now - shown_ < pause) return;
    shown_ = now;
    constexpr int kWidth = 30;
    if (terminal_) {
      const int filled = static_cast<int>(kWidth * share);
      fmt::print(stderr, "\r[{:{}}] {:3.0f} % of the pairs", std::string(filled, '#'), kWidth,
                 100 * share);
      drawn_ = true;
    } else {
      fmt::print(stderr, "{:.0f} % of the pairs\n", 100 * share);
    }
    std::fflush(stderr);
  }
  void Clear() {
    if (drawn_) fmt::print(stderr, "\r{:60}\r", "");
  }

 private:
  const bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point shown_ = std::chrono::steady_clock::now();
};

int RunFactors(FactorsFlags options) {
  const Result<Format> format = FormatOf(options.output);
  if (!format.has_value()) return Fail("factors", format.error());
  options.import.require_emission = false;
  options.import.prepare_for_transport = false;
  const Result<Scene> scene = ImportScene(options.scene, options.import);
  if (!scene.has_value()) return Fail("factors", scene.error());
  fmt::print(stderr, "{}", DescribeRepairs(scene->repairs));

  ThreadPool pool(options.threads);
  const auto start = std::chrono::steady_clock::now();
  Progress progress;
  options.factors.progress = [&](double share) { progress.Show(share); };
  const Result<FactorTable> table = ComputeFactors(*scene, options.factors, pool);
  progress.Clear();
  if (!table.has_value()) return Fail("factors", table.error().Within(options.scene));
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::string json;
  if (options.json || *format == Format::kJson) {
    json = FactorsAsJson(*table, scene->file_polygon_count, options.factors.tolerance, seconds);
  }
  if (const Status status = Write(options, *format, *table, json); !status.ok()) {
    return Fail("factors", status);
  }
  if (options.json) {
    fmt::print("{}", json);
  } else if (*format == Format::kNone) {
    fmt::print("{}", FactorsAsCsv(*table));
  }
  fmt::print(stderr, "{}", FactorsSummary(*table, options.factors.tolerance, seconds));
  return 0;
}

}  // namespace

void AddFactorsCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<FactorsFlags>();
  CLI::App* command =
      app.add_subcommand("factors", "form factors past obstacles between the polygons of a scene");
  command->add_option("scene", options->scene, "scene file (.obj, .gltf, .glb)")->required();
  command
      ->add_option("--tolerance", options->factors.tolerance,
                   "error of A_p F_pq over the smaller area of the two polygons")
      ->check(CLI::Range(1e-9, 1.0))
      ->capture_default_str();
  command->add_option("-o,--output", options->output,
                      "F.csv (row sums beside it in F.rows.csv) or F.json; without it, CSV on "
                      "standard output");
  command->add_option("--threads", options->threads, "0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  AddImportFlags(*command, &options->import);
  options->import.reflect_front = true;
  command->get_option("--reflect")
      ->description(
          "sides with factors of their own: the fronts (counter-clockwise) of all polygons, as "
          "enclosures are drawn, or both sides, told apart by a column")
      ->default_str("front");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &run] { run = [options] { return RunFactors(*options); }; });
}

}  // namespace isolux
