#include "client/import/import.h"

#include <strings.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <numbers>
#include <optional>

#include "client/import/gltf_reader.h"
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
  explicit MapMeans(const SceneFile& file) : file_(file) {}

  std::optional<Rgb> Get(const FileMap& map, Encoding encoding) {
    const bool embedded = map.embedded != kNoImage;
    const std::string name = embedded ? map.name : FindFile(map.folder, map.name);
    if (name.empty()) return std::nullopt;
    const auto [at, is_new] = means_.try_emplace({name, encoding});
    if (!is_new) return at->second;
    const Result<Rgb> mean =
        embedded ? LinearMean(file_.images[map.embedded], name, encoding) : LinearMean(name);
    if (mean.has_value()) at->second = *mean;
    return at->second;
  }

 private:
  const SceneFile& file_;
  std::map<std::pair<std::string, Encoding>, std::optional<Rgb>> means_;
};

void NoteEffects(const FileMaterial& from, RepairLog* log) {
  const auto where = [&] { return from.where; };
  if (from.opacity_map) log->Add(Repair::kOpacityMap, where);
  if (from.mirror) log->Add(Repair::kMirror, where);
  if (from.glossy) log->Add(Repair::kGlossy, where);
  if (from.glass) log->Add(Repair::kGlass, where);
  if (from.unlit) log->Add(Repair::kUnlit, where);
}

Material MakeMaterial(const FileMaterial& from, MapMeans* maps, RepairLog* log) {
  const auto where = [&] { return from.where; };
  // The mean of a map, 1 where there is none or it cannot be read.
  const auto mean_of = [&](const FileMap& map, Encoding encoding, Repair kind) {
    if (map.name.empty()) return Rgb(1.0);
    const std::optional<Rgb> mean = maps->Get(map, encoding);
    log->Add(mean ? kind : Repair::kNoMap, where);
    return mean.value_or(Rgb(1.0));
  };
  NoteEffects(from, log);
  Material material{from.name, from.diffuse, std::numbers::pi * from.radiance};
  material.reflectance *= mean_of(from.diffuse_map, Encoding::kSrgb, Repair::kMap);
  if (Sum(from.radiance) > 0) {
    material.exitance *= mean_of(from.emission_map, Encoding::kSrgb, Repair::kEmissionMap);
  }
  if (from.metallic > 0) {
    const double metal = mean_of(from.metallic_map, Encoding::kLinear, Repair::kMap).z;
    material.reflectance *= 1 - from.metallic * metal;
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
std::vector<Material> MakeMaterials(const SceneFile& file, RepairLog* log) {
  std::vector<bool> used(file.materials.size(), false);
  for (const FileFace& face : file.faces) {
    if (face.material != kNoMaterial) used[face.material] = true;
  }
  MapMeans maps(file);
  std::vector<Material> materials(file.materials.size());
  for (size_t m = 0; m < used.size(); ++m) {
    if (used[m]) materials[m] = MakeMaterial(file.materials[m], &maps, log);
  }
  materials.push_back({"", Rgb(kGrey), Rgb(0.0)});
  return materials;
}

// What the file says beside its surfaces, and does not count.
void NoteRest(const SceneFile& file, RepairLog* log) {
  const std::pair<Repair, const std::vector<std::string>*> rest[] = {
      {Repair::kNoLibrary, &file.missing_libraries},
      {Repair::kRepeatedMaterial, &file.repeated_materials},
      {Repair::kLight, &file.lights},
      {Repair::kLines, &file.lines},
      {Repair::kAnimated, &file.animated},
      {Repair::kCamera, &file.cameras}};
  for (const auto& [kind, places] : rest) {
    log->Add(kind, places->size(), [&places = *places] { return places[0]; });
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
  ASSIGN_OR_RETURN(const SceneFile file, format.read(path, SceneLimits()));
  RepairLog log;
  NoteRest(file, &log);
  scene.materials = MakeMaterials(file, &log);
  RETURN_IF_ERROR(BuildPolygons(file, options, &scene, &log));
  DropUnusedMaterials(&scene);
  if (options.strict) RETURN_IF_ERROR(log.CheckStrict());
  scene.repairs = log.Report();
  if (!Emits(scene)) {
    if (!options.require_emission) return scene;
    return Error(StatusCode::kInvalidArgument,
                 "{}: nothing emits light: no face has a material with {} (radiance in W/(m² sr))",
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
