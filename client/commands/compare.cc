// isolux compare a.ply b.ply [--samples N] [--force] [--json]
//
// How far the first solution is from the second, which is taken for the better one: the mean, the
// root mean square and the largest difference of irradiance over the mean irradiance of the second.
// Where both have the same spectral bands, those of each band too.
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

struct Compared {
  Comparison light;
  std::vector<Band> bands;  // that both have; empty: they have none in common
  BandsComparison of_bands;
  std::string without_bands;  // which of them is, where the other has some
};

Result<Compared> CompareFiles(const CompareFlags& options) {
  ASSIGN_OR_RETURN(const PatchFile a, ReadPatchFile(options.a));
  ASSIGN_OR_RETURN(const PatchFile b, ReadPatchFile(options.b));
  RETURN_IF_ERROR(CheckSameScene(a, b, options));
  Compared compared;
  ASSIGN_OR_RETURN(compared.light, Compare(a, b, options.comparison));
  if (a.bands.empty() != b.bands.empty()) {
    compared.without_bands = a.bands.empty() ? options.a : options.b;
  }
  if (!HaveSameBands(a, b)) return compared;
  compared.bands = b.bands;
  ASSIGN_OR_RETURN(compared.of_bands, CompareBands(a, b, options.comparison));
  return compared;
}

nlohmann::json ToJson(const Compared& compared) {
  const Comparison& light = compared.light;
  nlohmann::json json{{"l1_relative", light.l1_relative},   {"rms_relative", light.rms_relative},
                      {"max_relative", light.max_relative}, {"p95_local", light.p95_local},
                      {"samples", light.samples},           {"unmatched", light.unmatched}};
  if (compared.bands.empty()) return json;
  json["bands_l1_relative"] = compared.of_bands.l1_relative;
  for (size_t b = 0; b < compared.bands.size(); ++b) {
    const BandComparison& band = compared.of_bands.bands[b];
    json["bands"].push_back({{"low_nm", compared.bands[b].low_nm},
                             {"high_nm", compared.bands[b].high_nm},
                             {"dark", band.dark},
                             {"l1_relative", band.l1_relative},
                             {"rms_relative", band.rms_relative},
                             {"max_relative", band.max_relative}});
  }
  return json;
}

void PrintBands(const Compared& compared) {
  if (!compared.without_bands.empty()) {
    fmt::print("of red, green and blue alone: {} has no spectral bands\n", compared.without_bands);
  }
  if (compared.bands.empty()) return;
  fmt::print("mean of {:2} bands       {:.3f} %, each of its own mean irradiance:\n",
             compared.bands.size(), 100 * compared.of_bands.l1_relative);
  for (size_t b = 0; b < compared.bands.size(); ++b) {
    const BandComparison& band = compared.of_bands.bands[b];
    fmt::print("  {:g} to {:g} nm: ", compared.bands[b].low_nm, compared.bands[b].high_nm);
    if (band.dark) {
      fmt::print("dark in the second\n");
      continue;
    }
    fmt::print("{:.3f} %, root mean square {:.3f} %, largest {:.3f} %\n", 100 * band.l1_relative,
               100 * band.rms_relative, 100 * band.max_relative);
  }
}

int RunCompare(const CompareFlags& options) {
  const Result<Compared> compared = CompareFiles(options);
  if (!compared.has_value()) return Fail("compare", compared.error());
  if (options.json) {
    fmt::print("{}\n", ToJson(*compared).dump());
    return 0;
  }
  const Comparison& light = compared->light;
  fmt::print("mean difference        {:.3f} % of the mean irradiance\n", 100 * light.l1_relative);
  fmt::print("root mean square       {:.3f} %\n", 100 * light.rms_relative);
  fmt::print("largest                {:.3f} %\n", 100 * light.max_relative);
  fmt::print("95 % of points within  {:.3f} % of the irradiance there\n", 100 * light.p95_local);
  fmt::print("points                 {}", light.samples);
  if (light.unmatched > 0) {
    fmt::print(", {} of them on surfaces dark in one of the two", light.unmatched);
  }
  fmt::print("\n");
  PrintBands(*compared);
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
