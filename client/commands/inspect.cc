// isolux inspect scene.obj [--emit front|both] [--reflect both|front] [--unit m|cm|mm|in|ft]
//                          [--strict] [--accuracy A] [--effects CHOICE] [--cost]
//                          [--workers N] [--server HOST:PORT] [--json]
//
// What the importer found and mended, and which effects the scene calls for. A scene in which
// nothing emits is shown, too, with a word that it cannot be solved. With --cost, some seconds of
// coarse rounds (by a coordinator and workers of its own, or on the cluster of --server) tell what
// accuracies should take.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "client/commands/commands.h"
#include "client/commands/cost.h"
#include "client/commands/import_flags.h"
#include "common/hierarchy/effects/plan.h"
#include "common/scene/solve_options.h"

namespace isolux {
namespace {

using nlohmann::json;

struct InspectFlags {
  std::string scene;
  ImportOptions import;
  bool json = false;
  double accuracy = SolveOptions().accuracy;
  std::string effects = "auto";
  bool cost = false;
  CostOptions cluster;
  CostFunction measure_cost;
};

// What is counted about a scene.
struct Figures {
  uint64_t triangles = 0, quads = 0, emitters = 0;
  double area_m2 = 0;  // of the polygons, one side counted
  Bounds3 bounds;      // in the file's unit and place
  EffectsTable effects;
  uint64_t surfaces = 0;
};

Figures Count(const Scene& scene, double accuracy, const EffectsChoice& choice) {
  Figures figures;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
    ++(shape.count == 3 ? figures.triangles : figures.quads);
    figures.area_m2 += shape.Area();
    for (int i = 0; i < shape.count; ++i) {
      figures.bounds.Add((shape.v[i] + scene.origin_m) / scene.metres_per_unit);
    }
  }
  const Hierarchy hierarchy(scene);
  figures.surfaces = hierarchy.surfaces().size();
  figures.emitters =
      static_cast<uint64_t>(std::count_if(hierarchy.surfaces().begin(), hierarchy.surfaces().end(),
                                          [](const Surface& s) { return Sum(s.exitance) > 0; }));
  figures.effects = PlanEffects(hierarchy, accuracy, choice);
  return figures;
}

void PrintText(const Scene& scene, const Figures& figures) {
  const auto& [low, high] = figures.bounds;
  fmt::print("polygons in the file   {}\n", scene.file_polygon_count);
  fmt::print("polygons               {} ({} triangles, {} quads)\n", scene.polygons.size(),
             figures.triangles, figures.quads);
  fmt::print("surfaces               {}, {} of them emit\n", figures.surfaces, figures.emitters);
  fmt::print("materials              {}\n", scene.materials.size());
  fmt::print("area                   {:.6g} m², one side of each polygon\n", figures.area_m2);
  fmt::print("bounding box           ({:.6g} {:.6g} {:.6g}) to ({:.6g} {:.6g} {:.6g}) {}\n", low.x,
             low.y, low.z, high.x, high.y, high.z, scene.unit);
  const std::string repairs = DescribeRepairs(scene.repairs);
  fmt::print("\nrepairs{}\n{}", repairs.empty() ? ": none" : "", repairs);
  fmt::print("\n{:<16} {:<8} {:<9} {:<14} {}\n", "effect", "present", "bound", "decision",
             "evidence; reason");
  for (const Effect& effect : figures.effects.effects) {
    fmt::print("{:<16} {:<8} {:<9} {:<14} {}; {}\n", effect.name, effect.present ? "yes" : "no",
               effect.bound ? fmt::format("{:.3g}", *effect.bound) : "-", effect.decision,
               effect.evidence, effect.reason);
  }
}

json ToJson(const Scene& scene, const Figures& figures) {
  const auto point = [](const Vec3& p) { return json::array({p.x, p.y, p.z}); };
  json repairs = json::array();
  for (const RepairReport::Entry& entry : scene.repairs.entries) {
    repairs.push_back({{"kind", entry.kind}, {"count", entry.count}, {"example", entry.example}});
  }
  json effects = json::array();
  for (const Effect& effect : figures.effects.effects) {
    effects.push_back({{"name", effect.name},
                       {"present", effect.present},
                       {"evidence", effect.evidence},
                       {"bound", effect.bound ? json(*effect.bound) : json()},
                       {"decision", effect.decision},
                       {"reason", effect.reason}});
  }
  return {{"file_polygons", scene.file_polygon_count},
          {"polygons", scene.polygons.size()},
          {"triangles", figures.triangles},
          {"quads", figures.quads},
          {"surfaces", figures.surfaces},
          {"emitters", figures.emitters},
          {"materials", scene.materials.size()},
          {"area_m2", figures.area_m2},
          {"unit", scene.unit},
          {"bounds", {{"low", point(figures.bounds.low)}, {"high", point(figures.bounds.high)}}},
          {"scene_hash", HashOf(Encode(scene))},
          {"solvable", Emits(scene)},
          {"repairs", repairs},
          {"effects", effects},
          {"neglected", figures.effects.neglected}};
}

int RunInspect(InspectFlags options) {
  options.import.require_emission = false;
  const Result<Scene> scene = ImportScene(options.scene, options.import);
  if (!scene.has_value()) {
    fmt::print(stderr, "isolux inspect: {}\n", scene.error().message());
    return 2;
  }
  const Result<EffectsChoice> choice = ParseEffectsChoice(options.effects);
  if (!choice) {
    fmt::print(stderr, "isolux inspect: {}\n", choice.error().message());
    return 2;
  }
  const Figures figures = Count(*scene, options.accuracy, *choice);
  std::optional<CostTable> cost;
  if (options.cost && Emits(*scene)) {
    auto measured = options.measure_cost(
        *scene, std::filesystem::path(options.scene).filename().string(), options.cluster);
    if (!measured) {
      fmt::print(stderr, "isolux inspect: {}\n", measured.error().message());
      return 1;
    }
    cost = std::move(*measured);
  }
  if (options.json) {
    json all = ToJson(*scene, figures);
    if (cost) all["cost"] = ToJson(*cost);
    fmt::print("{}\n", all.dump(-1, ' ', false, json::error_handler_t::replace));
  } else {
    PrintText(*scene, figures);
    if (cost) fmt::print("\n{}", ToText(*cost));
  }
  if (!Emits(*scene)) {
    fmt::print(stderr, "isolux inspect: {}: nothing emits light, so there is nothing to solve\n",
               options.scene);
  }
  return 0;
}

}  // namespace

void AddInspectCommand(CLI::App& app, Run& run, const CostFunction& measure_cost) {
  auto options = std::make_shared<InspectFlags>();
  CLI::App* command =
      app.add_subcommand("inspect", "what the importer mends and what a scene calls for");
  command->add_option("scene", options->scene, "scene file (.obj, .gltf, .glb)")->required();
  AddImportFlags(*command, &options->import);
  command
      ->add_option("--accuracy", options->accuracy,
                   "mean error of the irradiance over its mean, by which effects are judged")
      ->check(CLI::Range(1e-9, 1.0))
      ->capture_default_str();
  AddEffectsFlag(*command, &options->effects);
  if (measure_cost) {
    options->measure_cost = measure_cost;
    CLI::Option* cost = command->add_flag(
        "--cost", options->cost, "run a few coarse rounds and say what accuracies should take");
    command->add_option("--workers", options->cluster.workers, "worker processes, for --cost")
        ->needs(cost)
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command
        ->add_option("--server", options->cluster.server,
                     "HOST:PORT of a coordinator, for --cost [one of its own]")
        ->needs(cost);
  }
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &run] { run = [options] { return RunInspect(*options); }; });
}

}  // namespace isolux
