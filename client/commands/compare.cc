// isolux compare a.ply b.ply [--samples N] [--force] [--json]
//
// How far the first solution is from the second, which is taken for the better one: the mean, the
// root mean square and the largest difference of irradiance over the mean irradiance of the second.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "client/commands/commands.h"
#include "client/commands/fail.h"
#include "client/output/comparison.h"

namespace isolux {
namespace {

struct CompareFlags {
  std::string a, b;
  ComparisonOptions comparison;
  bool force = false, json = false;
};

Status CheckSameScene(const PatchFile& a, const PatchFile& b, const CompareFlags& options) {
  const std::string hash_a = a.Comment("scene_hash"), hash_b = b.Comment("scene_hash");
  if (options.force || (hash_a == hash_b && !hash_a.empty())) return {};
  const auto shown = [](const std::string& hash) { return hash.empty() ? "not given" : hash; };
  return MakeStatus(StatusCode::kInvalidArgument,
                    "{} and {} are solutions of different scenes (scene_hash {} and {}); --force "
                    "compares them all the same",
                    options.a, options.b, shown(hash_a), shown(hash_b));
}

Result<Comparison> CompareFiles(const CompareFlags& options) {
  ASSIGN_OR_RETURN(const PatchFile a, ReadPatchFile(options.a));
  ASSIGN_OR_RETURN(const PatchFile b, ReadPatchFile(options.b));
  RETURN_IF_ERROR(CheckSameScene(a, b, options));
  return Compare(a, b, options.comparison);
}

int RunCompare(const CompareFlags& options) {
  const Result<Comparison> result = CompareFiles(options);
  if (!result.has_value()) return Fail("compare", result.error());
  if (options.json) {
    const nlohmann::json json{
        {"l1_relative", result->l1_relative},   {"rms_relative", result->rms_relative},
        {"max_relative", result->max_relative}, {"p95_local", result->p95_local},
        {"samples", result->samples},           {"unmatched", result->unmatched}};
    fmt::print("{}\n", json.dump());
    return 0;
  }
  fmt::print("mean difference        {:.3f} % of the mean irradiance\n", 100 * result->l1_relative);
  fmt::print("root mean square       {:.3f} %\n", 100 * result->rms_relative);
  fmt::print("largest                {:.3f} %\n", 100 * result->max_relative);
  fmt::print("95 % of points within  {:.3f} % of the irradiance there\n", 100 * result->p95_local);
  fmt::print("points                 {}", result->samples);
  if (result->unmatched > 0) {
    fmt::print(", {} of them on surfaces dark in one of the two", result->unmatched);
  }
  fmt::print("\n");
  return 0;
}

}  // namespace

void AddCompareCommand(CLI::App& app, Run& run) {
  auto options = std::make_shared<CompareFlags>();
  CLI::App* command = app.add_subcommand("compare", "error between two solutions of one scene");
  command->add_option("a", options->a, "patch file to judge")->required();
  command->add_option("b", options->b, "patch file to judge it by")->required();
  command->add_option("--samples", options->comparison.samples, "points, uniform over the surfaces")
      ->check(CLI::Range(uint64_t{1}, uint64_t{1} << 28))
      ->capture_default_str();
  command->add_option("--seed", options->comparison.seed, "of the points")->capture_default_str();
  command->add_flag("--force", options->force, "also when the scenes differ");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &run] { run = [options] { return RunCompare(*options); }; });
}

}  // namespace isolux
