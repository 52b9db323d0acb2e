#include "client/import/import.h"

#include <strings.h>

#include <filesystem>

#include "client/import/gltf_reader.h"
#include "client/import/lights_file.h"
#include "client/import/materials.h"
#include "client/import/obj_reader.h"
#include "client/import/repair.h"
#include "client/import/spectra_file.h"

namespace isolux {
namespace {

// Leaves out what is not in use, keeping the order of the rest. `for_each_use(visit)` calls visit
// with each number that is in use, which it then rewrites.
template <typename T, typename ForEachUse>
void KeepUsed(std::vector<T>* items, const ForEachUse& for_each_use) {
  std::vector<uint32_t> number(items->size(), 0);
  for_each_use([&](uint32_t& use) {
    if (use < number.size()) number[use] = 1;
  });
  std::vector<T> kept;
  for (size_t i = 0; i < number.size(); ++i) {
    if (number[i] == 0) continue;
    number[i] = static_cast<uint32_t>(kept.size());
    kept.push_back(std::move((*items)[i]));
  }
  for_each_use([&](uint32_t& use) {
    if (use < number.size()) use = number[use];
  });
  *items = std::move(kept);
}

void DropUnused(Scene* scene) {
  KeepUsed(&scene->materials, [&](const auto& visit) {
    for (Polygon& polygon : scene->polygons) visit(polygon.material);
  });
  KeepUsed(&scene->coordinates, [&](const auto& visit) {
    for (Polygon& polygon : scene->polygons) visit(polygon.coordinates);
  });
  std::vector<bool> varies(scene->materials.size(), false);
  for (const Polygon& polygon : scene->polygons) {
    if (polygon.coordinates != kNoCoordinates) varies[polygon.material] = true;
  }
  for (size_t m = 0; m < varies.size(); ++m) {
    if (!varies[m]) scene->materials[m].reflectance_map = scene->materials[m].exitance_map = {};
  }
  KeepUsed(&scene->textures, [&](const auto& visit) {
    for (Material& material : scene->materials) {
      visit(material.reflectance_map.texture);
      visit(material.exitance_map.texture);
    }
  });
}

Result<double> MetresPer(const std::string& unit) {
  const std::pair<const char*, double> units[] = {
      {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : units) {
    if (unit == name) return metres;
  }
  return Error(StatusCode::kInvalidArgument, "unit '{}': choose m, cm, mm, in or ft", unit);
}

// What the file says beside its surfaces, and does not count.
void NoteRest(const SceneFile& file, RepairLog* log) {
  const std::pair<Repair, const std::vector<std::string>*> rest[] = {
      {Repair::kNoLibrary, &file.missing_libraries},
      {Repair::kRepeatedMaterial, &file.repeated_materials},
      {Repair::kLines, &file.lines},
      {Repair::kAnimated, &file.animated},
      {Repair::kCamera, &file.cameras}};
  for (const auto& [kind, places] : rest) {
    log->Add(kind, places->size(), [&places = *places] { return places[0]; });
  }
}

// Lights in the place and unit of the scene, which has its polygons.
void PlaceLights(const std::vector<Light>& lights, Scene* scene) {
  for (Light light : lights) {
    if (!(Sum(light.intensity) > 0)) continue;
    light.position_m = light.kind == LightKind::kDirectional
                           ? Vec3(0.0)
                           : light.position_m * scene->metres_per_unit - scene->origin_m;
    scene->lights.push_back(light);
  }
}

struct Format {
  const char* extension;
  Result<SceneFile> (*read)(const std::string& path, const SceneLimits& limits);
  const char* emission;  // how a material of it emits
};

constexpr Format kFormats[] = {
    {".obj", ReadObj, "Ke above 0; give the lamps' material a line 'Ke r g b'"},
    {".gltf", ReadGltf, "emissiveFactor above 0; give the lamps' material one"},
    {".glb", ReadGltf, "emissiveFactor above 0; give the lamps' material one"},
};

Result<Scene> Import(const std::string& path, const Format& format, const ImportOptions& options) {
  Scene scene;
  ASSIGN_OR_RETURN(scene.metres_per_unit, MetresPer(options.unit));
  scene.unit = options.unit;
  ASSIGN_OR_RETURN(SceneFile file, format.read(path, SceneLimits()));
  RETURN_IF_ERROR(AddLightsFile(&file));
  RepairLog log;
  NoteRest(file, &log);
  const std::vector<Glass> glasses = MakeMaterials(file, &scene, &log);
  RETURN_IF_ERROR(ApplySpectra(file, &scene));
  RETURN_IF_ERROR(BuildPolygons(file, glasses, options, &scene, &log));
  DropUnused(&scene);
  PlaceLights(file.lights, &scene);
  if (!scene.lights.empty()) scene.photometries = std::move(file.photometries);
  scene.sky = std::move(file.sky);
  scene.medium = file.medium;
  if (options.strict) RETURN_IF_ERROR(log.CheckStrict());
  scene.repairs = log.Report();
  if (!Emits(scene)) {
    if (!options.require_emission) return scene;
    return Error(StatusCode::kInvalidArgument,
                 "{}: nothing emits light: no face has a material with {} (radiance in W/(m² sr)), "
                 "and there are no lights",
                 path, format.emission);
  }
  if (const Status status = Validate(scene); !status.ok()) {
    return tl::unexpected(status.Within(path));
  }
  return scene;
}

}  // namespace

Result<Scene> ImportScene(const std::string& path, const ImportOptions& options) {
  const std::string extension = std::filesystem::path(path).extension().string();
  for (const Format& format : kFormats) {
    if (strcasecmp(extension.c_str(), format.extension) == 0) return Import(path, format, options);
  }
  return Error(StatusCode::kInvalidArgument,
               "{}: '{}' is not a scene format; give a Wavefront file (.obj) or glTF 2.0 (.gltf, "
               ".glb)",
               path, extension);
}

}  // namespace isolux
