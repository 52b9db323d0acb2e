#include "client/import/import.h"

#include <strings.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>

#include "client/import/obj_reader.h"
#include "client/import/repair.h"
#include "client/import/text_file.h"
#include "client/import/texture_mean.h"

namespace isolux {
namespace {

constexpr double kLargestReflectance = 0.98;  // what 1 or more becomes
constexpr double kGrey = 0.5;                 // of faces without a material

// Means of images, each decoded once; nothing where an image is missing or unreadable.
class MapMeans {
 public:
  std::optional<Rgb> Get(const std::string& folder, const std::string& name) {
    const std::string path = FindFile(folder, name);
    if (path.empty()) return std::nullopt;
    const auto known = means_.find(path);
    if (known != means_.end()) return known->second;
    const Result<Rgb> mean = LinearMean(path);
    return means_[path] = mean.has_value() ? std::optional<Rgb>(*mean) : std::nullopt;
  }

 private:
  std::map<std::string, std::optional<Rgb>> means_;
};

void NoteEffects(const MtlMaterial& from, RepairLog* log) {
  const auto where = [&] { return from.where; };
  if (from.emission_map) log->Add(Repair::kEmissionMap, where);
  if (from.opacity_map) log->Add(Repair::kOpacityMap, where);
  if (from.mirror) log->Add(Repair::kMirror, where);
  if (from.glossy) log->Add(Repair::kGlossy, where);
  if (from.glass) log->Add(Repair::kGlass, where);
}

Material MakeMaterial(const MtlMaterial& from, MapMeans* maps, RepairLog* log) {
  const auto where = [&] { return from.where; };
  NoteEffects(from, log);
  Material material{from.name, from.diffuse, std::numbers::pi * from.radiance};
  if (!from.diffuse_map.empty()) {
    const std::optional<Rgb> mean = maps->Get(from.folder, from.diffuse_map);
    log->Add(mean ? Repair::kMap : Repair::kNoMap, where);
    material.reflectance *= mean.value_or(Rgb(1.0));
  }
  bool lowered = false;
  for (int c = 0; c < 3; ++c) {
    if (material.reflectance[c] < 1) continue;
    material.reflectance[c] = kLargestReflectance;
    lowered = true;
  }
  if (lowered) log->Add(Repair::kReflectance, where);
  return material;
}

// Leaves out materials that no polygon has, keeping the order of the others.
void DropUnusedMaterials(Scene* scene) {
  std::vector<uint32_t> number(scene->materials.size(), 0);
  for (const Polygon& polygon : scene->polygons) number[polygon.material] = 1;
  std::vector<Material> kept;
  for (size_t m = 0; m < number.size(); ++m) {
    if (number[m] == 0) continue;
    number[m] = static_cast<uint32_t>(kept.size());
    kept.push_back(std::move(scene->materials[m]));
  }
  for (Polygon& polygon : scene->polygons) polygon.material = number[polygon.material];
  scene->materials = std::move(kept);
}

Result<double> MetresPer(const std::string& unit) {
  const std::pair<const char*, double> units[] = {
      {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : units) {
    if (unit == name) return metres;
  }
  return Error(StatusCode::kInvalidArgument, "unit '{}': choose m, cm, mm, in or ft", unit);
}

// Only materials of faces count: their maps are read, their defects reported.
std::vector<Material> MakeMaterials(const ObjFile& file, RepairLog* log) {
  std::vector<bool> used(file.materials.size(), false);
  for (const ObjFace& face : file.faces) {
    if (face.material != kNoMaterial) used[face.material] = true;
  }
  MapMeans maps;
  std::vector<Material> materials(file.materials.size());
  for (size_t m = 0; m < used.size(); ++m) {
    if (used[m]) materials[m] = MakeMaterial(file.materials[m], &maps, log);
  }
  materials.push_back({"", Rgb(kGrey), Rgb(0.0)});
  return materials;
}

Result<Scene> ImportObj(const std::string& path, const ImportOptions& options) {
  Scene scene;
  ASSIGN_OR_RETURN(scene.metres_per_unit, MetresPer(options.unit));
  scene.unit = options.unit;
  ASSIGN_OR_RETURN(const ObjFile file, ReadObj(path));
  RepairLog log;
  for (const std::string& where : file.missing_libraries) {
    log.Add(Repair::kNoLibrary, [&] { return where; });
  }
  for (const std::string& where : file.repeated_materials) {
    log.Add(Repair::kRepeatedMaterial, [&] { return where; });
  }
  scene.materials = MakeMaterials(file, &log);
  RETURN_IF_ERROR(BuildPolygons(file, options, &scene, &log));
  DropUnusedMaterials(&scene);
  if (options.strict) RETURN_IF_ERROR(log.CheckStrict());
  scene.repairs = log.Report();
  if (!Emits(scene)) {
    if (!options.require_emission) return scene;
    return Error(StatusCode::kInvalidArgument,
                 "{}: nothing emits light: no face has a material with Ke above 0; give the lamps' "
                 "material a line 'Ke r g b' (radiance in W/(m² sr))",
                 path);
  }
  if (const Status status = Validate(scene); !status.ok()) {
    return tl::unexpected(status.Within(path));
  }
  return scene;
}

}  // namespace

Result<Scene> ImportScene(const std::string& path, const ImportOptions& options) {
  const std::string extension = std::filesystem::path(path).extension().string();
  if (strcasecmp(extension.c_str(), ".obj") == 0) return ImportObj(path, options);
  return Error(StatusCode::kInvalidArgument,
               "{}: '{}' is not a scene format; give a Wavefront file (.obj)", path, extension);
}

}  // namespace isolux
