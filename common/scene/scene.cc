#include "common/scene/scene.h"

#include <xxhash.h>

#include <algorithm>
#include <cmath>

#include "common/scene/bands.h"
#include "common/scene/fluorescence_bytes.h"
#include "common/scene/gloss.h"
#include "common/scene/specular.h"
#include "common/scene/translucency.h"
#include "common/util/bytes.h"

namespace isolux {
namespace {

constexpr uint64_t kMagic = 0x314e435358554c49ULL;        // "ILUXSCN1"
constexpr uint64_t kLightsMagic = 0x3154484758554c49ULL;  // "ILUXGHT1": what follows are lights
constexpr uint64_t kSkyMagic = 0x31594b5358554c49ULL;     // "ILUXSKY1": what follows is the sky
constexpr uint64_t kMediumMagic = 0x3144454d58554c49ULL;  // "ILUXMED1": the medium
constexpr uint64_t kVertexBytes = 3 * 8;
constexpr uint64_t kPolygonBytes = 6 * 4 + 1;
constexpr uint64_t kMaterialBytes = 4 + 6 * 8;   // without the name
constexpr uint64_t kMapBytes = 2 * (4 + 6 * 8);  // of a material
constexpr uint64_t kCoordinatesBytes = 8 * 8;
constexpr uint32_t kLongestName = 1024;
constexpr uint8_t kAllSides =
    kFrontTakesPart | kBackTakesPart | kFrontEmits | kBackEmits | kFrontCovered | kBackCovered;

// Products of three lengths and of exitances with areas must stay far from overflow.
constexpr double kLargestCoordinateM = 1e9;
constexpr double kLargestExitance = 1e30;

bool Finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

double LargestOf(const Vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

Status CheckLimits(uint64_t vertices, uint64_t polygons, uint64_t materials,
                   const SceneLimits& limits) {
  const auto check = [](uint64_t count, uint64_t most, const char* what) {
    if (count <= most) return Status();
    return MakeStatus(StatusCode::kResourceExhausted,
                      "the scene has {} {}, more than the limit of {}; simplify or divide it",
                      count, what, most);
  };
  RETURN_IF_ERROR(check(vertices, limits.vertices, "vertices"));
  RETURN_IF_ERROR(check(polygons, limits.polygons, "polygons"));
  return check(materials, limits.materials, "materials");
}

Status CheckIndices(const Polygon& polygon, uint64_t vertices, uint64_t materials) {
  for (int i = 0; i < polygon.vertex_count(); ++i) {
    if (polygon.vertices[i] >= vertices) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "polygon {}: vertex {} does not exist, the scene has {}",
                        polygon.file_polygon, polygon.vertices[i], vertices);
    }
  }
  if (polygon.material >= materials) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "polygon {}: material {} does not exist, the scene has {}",
                      polygon.file_polygon, polygon.material, materials);
  }
  if ((polygon.sides & ~kAllSides) != 0) {
    return MakeStatus(StatusCode::kInvalidArgument, "polygon {}: unknown side flags {:#x}",
                      polygon.file_polygon, polygon.sides);
  }
  return {};
}

// Textures, what materials and polygons have of them, and that no texel reflects all or more.
Status CheckMaps(const Scene& scene) {
  for (size_t t = 0; t < scene.textures.size(); ++t) {
    const Status status = CheckTexture(scene.textures[t]);
    if (!status.ok()) return status.Within(fmt::format("texture {}", t));
  }
  const auto finite = [](const auto& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](double n) { return std::abs(n) < 1e15; });
  };
  for (const Material& material : scene.materials) {
    for (const TextureUse* use : {&material.reflectance_map, &material.exitance_map}) {
      if (use->texture != kNoTexture && use->texture >= scene.textures.size()) {
        return MakeStatus(StatusCode::kInvalidArgument, "material '{}': no texture {}",
                          material.name, use->texture);
      }
      if (!finite(use->transform)) {
        return MakeStatus(StatusCode::kInvalidArgument,
                          "material '{}': its texture transform is out of range", material.name);
      }
    }
    const uint32_t map = material.reflectance_map.texture;
    if (map == kNoTexture) continue;
    const Rgb most = material.reflectance * LargestTexel(scene.textures[map]) +
                     material.transmittance + material.reradiation.Taken();
    if (std::max({most.x, most.y, most.z}) < 1) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "material '{}': its map reaches a reflectance of 1, with what passes or is "
                      "reradiated; lower Kd",
                      material.name);
  }
  for (const Polygon& polygon : scene.polygons) {
    if (polygon.coordinates == kNoCoordinates) continue;
    if (polygon.coordinates >= scene.coordinates.size()) {
      return MakeStatus(StatusCode::kInvalidArgument, "polygon {}: no texture coordinates {}",
                        polygon.file_polygon, polygon.coordinates);
    }
  }
  for (const TextureCoordinates& c : scene.coordinates) {
    if (finite(c.u) && finite(c.v)) continue;
    return MakeStatus(StatusCode::kInvalidArgument, "texture coordinates out of range");
  }
  return {};
}

Status CheckMaterial(const Material& material, size_t number) {
  const auto fail = [&](const char* what, const Rgb& value, const char* remedy) {
    return MakeStatus(StatusCode::kInvalidArgument, "material {} '{}': {} ({} {} {}): {}", number,
                      material.name, what, value.x, value.y, value.z, remedy);
  };
  for (int c = 0; c < 3; ++c) {
    if (!(material.reflectance[c] >= 0 && material.reflectance[c] < 1)) {
      return fail("reflectance outside [0, 1)", material.reflectance, "lower Kd below 1");
    }
    if (!(material.exitance[c] >= 0 && material.exitance[c] <= kLargestExitance)) {
      return fail("exitance negative, too large or not a number", material.exitance,
                  "give Ke as radiance in W/(m² sr), 0 or more");
    }
    if (!(material.specular >= 0 && material.reflectance[c] + material.specular <= 1 + 1e-9)) {
      return fail("a mirror that reflects more than it receives", material.reflectance,
                  "lower Ks, or Kd, to 1 together");
    }
    const double passed = material.transmittance[c], taken = material.reradiation.Taken()[c];
    const double sum = material.reflectance[c] + material.specular + passed + taken;
    const Reradiation& reradiation = material.reradiation;
    if (!(passed >= 0 && taken >= 0 && reradiation.blue_to_red >= 0 &&
          reradiation.blue_to_green >= 0 && (passed + taken == 0 || sum < 1))) {
      return fail("a surface that reflects, passes on and reradiates all that it receives, or more",
                  material.transmittance + reradiation.Taken(),
                  "lower Td, Fl, or Kd, below 1 together");
    }
    const double lobe = material.gloss.share[c];
    if (!(lobe >= 0 && lobe <= 1 && (material.gloss.kept ? 0 : lobe) + sum <= 1 + 1e-9)) {
      return fail("a lobe that reflects more than is left", material.gloss.share,
                  "lower Ks, or Kd, to 1 together");
    }
  }
  return {};
}

Status CheckShape(const Scene& scene, size_t p) {
  const ConvexPolygon shape = SideGeometry(scene, static_cast<uint32_t>(p), Side::kFront);
  const uint32_t number = scene.polygons[p].file_polygon;
  if (!HasArea(shape)) {
    return MakeStatus(StatusCode::kInvalidArgument, "polygon {}: no area; leave it out", number);
  }
  if (!IsPlanar(shape)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "polygon {}: its corners are not in one plane; divide it into triangles",
                      number);
  }
  if (!IsConvex(shape)) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "polygon {}: not convex; divide it into triangles", number);
  }
  return {};
}

// -0 and 0 are equal, so they are written alike.
void Put(ByteWriter& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) out.Put(v[i] + 0.0);
}

Vec3 GetVec3(ByteReader& in) {
  Vec3 v;
  for (int i = 0; i < 3; ++i) v[i] = in.Get<double>();
  return v;
}

Polygon GetPolygon(ByteReader& in) {
  Polygon polygon;
  for (uint32_t& v : polygon.vertices) v = in.Get<uint32_t>();
  polygon.material = in.Get<uint32_t>();
  polygon.file_polygon = in.Get<uint32_t>();
  polygon.sides = in.Get<uint8_t>();
  return polygon;
}

// Behind all else, and only where a scene has maps.
void PutMaps(ByteWriter& out, const Scene& scene) {
  out.Put(static_cast<uint64_t>(scene.textures.size()));
  out.Put(static_cast<uint64_t>(scene.coordinates.size()));
  for (const Texture& texture : scene.textures) {
    out.Put(texture.width);
    out.Put(texture.height);
    out.Put(static_cast<uint8_t>(texture.wrap_u));
    out.Put(static_cast<uint8_t>(texture.wrap_v));
    for (const float value : texture.texels) out.Put(value + 0.0F);
  }
  for (const Material& material : scene.materials) {
    for (const TextureUse* use : {&material.reflectance_map, &material.exitance_map}) {
      out.Put(use->texture);
      for (const double number : use->transform) out.Put(number + 0.0);
    }
  }
  for (const TextureCoordinates& c : scene.coordinates) {
    for (const double number : c.u) out.Put(number + 0.0);
    for (const double number : c.v) out.Put(number + 0.0);
  }
  for (const Polygon& polygon : scene.polygons) out.Put(polygon.coordinates);
}

// Behind the maps, and only where a scene has lights.
void PutLights(ByteWriter& out, const Scene& scene) {
  out.Put(kLightsMagic);
  out.Put(static_cast<uint64_t>(scene.lights.size()));
  out.Put(static_cast<uint64_t>(scene.photometries.size()));
  for (const Photometry& photometry : scene.photometries) Put(out, photometry);
  for (const Light& light : scene.lights) Put(out, light);
}

Status CheckLights(const Scene& scene) {
  for (const Photometry& photometry : scene.photometries) {
    RETURN_IF_ERROR(CheckPhotometry(photometry));
  }
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    RETURN_IF_ERROR(CheckLight(scene.lights[i], scene.photometries, i));
  }
  return {};
}

Status GetLights(ByteReader& in, const SceneLimits& limits, Scene* scene) {
  in.Get<uint64_t>();  // the magic number, which has been looked at
  const auto count = in.Get<uint64_t>();
  const auto tables = in.Get<uint64_t>();
  if (count == 0 || count > limits.lights || tables > limits.photometries) {
    return MakeStatus(StatusCode::kResourceExhausted,
                      "scene: {} lights and {} photometric tables, outside the limits", count,
                      tables);
  }
  for (uint64_t i = 0; i < tables && in.ok(); ++i) {
    scene->photometries.push_back(GetPhotometry(in));
  }
  if (!in.Holds(count, kLeastLightBytes)) {
    return MakeStatus(StatusCode::kDataLoss, "scene: its lights are missing");
  }
  for (uint64_t i = 0; i < count && in.ok(); ++i) scene->lights.push_back(GetLight(in));
  return CheckLights(*scene);
}

// At the end, and only where there is one.
Status TakeMedium(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();  // the magic number, which has been looked at
  scene->medium.extinction_per_m = GetVec3(in);
  if (!in.ok() || !scene->medium.exists()) {
    return MakeStatus(StatusCode::kDataLoss, "scene: its medium is missing");
  }
  return CheckMedium(scene->medium);
}

// Behind the lights, and only where there is one.
Status TakeSky(ByteReader& in, Scene* scene) {
  in.Get<uint64_t>();  // the magic number, which has been looked at
  scene->sky = GetSky(in);
  if (!in.ok() || !scene->sky.exists()) {
    return MakeStatus(StatusCode::kDataLoss, "scene: its sky is missing");
  }
  return CheckSky(scene->sky);
}

Status GetMaps(ByteReader& in, const SceneLimits& limits, Scene* scene) {
  const auto textures = in.Get<uint64_t>();
  const auto coordinates = in.Get<uint64_t>();
  if (textures == 0 || textures > limits.materials * 2 || coordinates > limits.polygons) {
    return MakeStatus(StatusCode::kResourceExhausted,
                      "scene: {} textures and {} texture coordinates, outside the limits", textures,
                      coordinates);
  }
  for (uint64_t t = 0; t < textures && in.ok(); ++t) {
    Texture& texture = scene->textures.emplace_back();
    texture.width = in.Get<uint32_t>();
    texture.height = in.Get<uint32_t>();
    texture.wrap_u = static_cast<Wrap>(in.Get<uint8_t>());
    texture.wrap_v = static_cast<Wrap>(in.Get<uint8_t>());
    if (texture.width > Texture::kMostTexels || texture.height > Texture::kMostTexels) {
      return MakeStatus(StatusCode::kDataLoss, "scene: texture {} is too large", t);
    }
    const uint64_t count = 3ULL * texture.width * texture.height;
    if (!in.Holds(count, sizeof(float))) break;
    texture.texels.resize(count);
    for (float& value : texture.texels) value = in.Get<float>();
  }
  if (!in.Holds(coordinates, kCoordinatesBytes) || !in.Holds(scene->materials.size(), kMapBytes)) {
    return MakeStatus(StatusCode::kDataLoss, "scene: its maps are missing");
  }
  for (Material& material : scene->materials) {
    for (TextureUse* use : {&material.reflectance_map, &material.exitance_map}) {
      use->texture = in.Get<uint32_t>();
      for (double& number : use->transform) number = in.Get<double>();
    }
  }
  scene->coordinates.resize(coordinates);
  for (TextureCoordinates& c : scene->coordinates) {
    for (double& number : c.u) number = in.Get<double>();
    for (double& number : c.v) number = in.Get<double>();
  }
  for (Polygon& polygon : scene->polygons) polygon.coordinates = in.Get<uint32_t>();
  return CheckMaps(*scene);
}

}  // namespace

bool Emits(const Scene& scene) {
  if (Sum(scene.sky.MeanRadiance()) > 0) return true;
  const auto shines = [](const Light& light) { return Sum(light.intensity) > 0; };
  if (std::any_of(scene.lights.begin(), scene.lights.end(), shines)) return true;
  return std::any_of(scene.polygons.begin(), scene.polygons.end(), [&](const Polygon& p) {
    return (p.sides & (kFrontEmits | kBackEmits)) != 0 &&
           Sum(scene.materials[p.material].exitance) > 0;
  });
}

Status Validate(const Scene& scene, const SceneLimits& limits) {
  RETURN_IF_ERROR(
      CheckLimits(scene.vertices.size(), scene.polygons.size(), scene.materials.size(), limits));
  if (scene.polygons.empty()) {
    return MakeStatus(StatusCode::kInvalidArgument, "the scene has no polygons");
  }
  if (!(scene.metres_per_unit > 0 && std::isfinite(scene.metres_per_unit))) {
    return MakeStatus(StatusCode::kInvalidArgument, "{} metres per unit is not a length",
                      scene.metres_per_unit);
  }
  if (!Finite(scene.origin_m)) {
    return MakeStatus(StatusCode::kInvalidArgument, "the origin of the scene is not a point");
  }
  for (size_t v = 0; v < scene.vertices.size(); ++v) {
    const Vec3& point = scene.vertices[v];
    if (!Finite(point) || LargestOf(point) > kLargestCoordinateM) {
      return MakeStatus(StatusCode::kInvalidArgument,
                        "vertex {} ({} {} {} m) is not a point within {:g} m; is the unit right?",
                        v, point.x, point.y, point.z, kLargestCoordinateM);
    }
  }
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    RETURN_IF_ERROR(CheckMaterial(scene.materials[m], m));
  }
  RETURN_IF_ERROR(CheckBands(scene));
  for (uint32_t group = 0; group < BandGroupCount(scene.bands.size()); ++group) {
    for (size_t m = 0; m < scene.materials.size(); ++m) {
      RETURN_IF_ERROR(CheckMaterial(MaterialOfGroup(scene, scene.materials[m], group), m));
    }
  }
  RETURN_IF_ERROR(CheckMaps(scene));
  if (scene.lights.size() > limits.lights) {
    return MakeStatus(StatusCode::kResourceExhausted,
                      "the scene has {} lights, more than the limit of {}; leave some out",
                      scene.lights.size(), limits.lights);
  }
  RETURN_IF_ERROR(CheckLights(scene));
  RETURN_IF_ERROR(CheckSky(scene.sky));
  RETURN_IF_ERROR(CheckMedium(scene.medium));
  RETURN_IF_ERROR(CheckGlazing(scene.glazing, limits.polygons));
  for (size_t p = 0; p < scene.polygons.size(); ++p) {
    RETURN_IF_ERROR(CheckIndices(scene.polygons[p], scene.vertices.size(), scene.materials.size()));
    RETURN_IF_ERROR(CheckShape(scene, p));
  }
  if (!Emits(scene)) {
    return MakeStatus(
        StatusCode::kInvalidArgument,
        "nothing in the scene emits light: give a material Ke above 0, or add a light");
  }
  return {};
}

std::string Encode(const Scene& scene) {
  ByteWriter out(256 + kVertexBytes * scene.vertices.size() +
                 kPolygonBytes * scene.polygons.size() +
                 (kMaterialBytes + 32) * scene.materials.size());
  out.Put(kMagic);
  out.Put(static_cast<uint64_t>(scene.vertices.size()));
  out.Put(static_cast<uint64_t>(scene.polygons.size()));
  out.Put(static_cast<uint64_t>(scene.materials.size()));
  out.Put(scene.file_polygon_count);
  Put(out, scene.origin_m);
  out.Put(scene.metres_per_unit);
  out.PutText(scene.unit);
  for (const Vec3& v : scene.vertices) Put(out, v);
  for (const Polygon& polygon : scene.polygons) {
    for (const uint32_t v : polygon.vertices) out.Put(v);
    out.Put(polygon.material);
    out.Put(polygon.file_polygon);
    out.Put(polygon.sides);
  }
  for (const Material& material : scene.materials) {
    out.PutText(std::string_view(material.name).substr(0, kLongestName));
    Put(out, material.reflectance);
    Put(out, material.exitance);
  }
  if (!scene.textures.empty()) PutMaps(out, scene);
  if (!scene.lights.empty()) PutLights(out, scene);
  if (scene.sky.exists()) {
    out.Put(kSkyMagic);
    Put(out, scene.sky);
  }
  PutMirrors(out, scene);
  PutGloss(out, scene);
  if (scene.medium.exists()) {
    out.Put(kMediumMagic);
    Put(out, scene.medium.extinction_per_m);
  }
  PutSheets(out, scene);
  PutGlazing(out, scene.glazing);
  PutFluorescence(out, scene);
  PutBands(out, scene);
  return out.Take();
}

Result<Scene> Decode(const std::string& bytes, const SceneLimits& limits) {
  if (bytes.size() > limits.bytes) {
    return Error(StatusCode::kResourceExhausted, "scene of {} bytes, more than the limit of {}",
                 bytes.size(), limits.bytes);
  }
  ByteReader in(bytes);
  if (in.Get<uint64_t>() != kMagic) {
    return Error(StatusCode::kDataLoss, "scene: not a scene of this version");
  }
  const auto vertices = in.Get<uint64_t>();
  const auto polygons = in.Get<uint64_t>();
  const auto materials = in.Get<uint64_t>();
  RETURN_IF_ERROR(CheckLimits(vertices, polygons, materials, limits));
  Scene scene;
  scene.file_polygon_count = in.Get<uint32_t>();
  scene.origin_m = GetVec3(in);
  scene.metres_per_unit = in.Get<double>();
  scene.unit = in.GetText(kLongestName);
  if (!in.Holds(vertices * kVertexBytes + polygons * kPolygonBytes + materials * kMaterialBytes,
                1)) {
    return Error(StatusCode::kDataLoss, "scene: {} bytes do not hold what the head announces",
                 bytes.size());
  }
  scene.vertices.resize(vertices);
  for (Vec3& v : scene.vertices) v = GetVec3(in);
  scene.polygons.resize(polygons);
  for (Polygon& polygon : scene.polygons) {
    polygon = GetPolygon(in);
    RETURN_IF_ERROR(CheckIndices(polygon, vertices, materials));
  }
  scene.materials.resize(materials);
  for (Material& material : scene.materials) {
    material.name = in.GetText(kLongestName);
    material.reflectance = GetVec3(in);
    material.exitance = GetVec3(in);
  }
  // None is a number of textures that a scene may have.
  const auto follows = [&in](uint64_t magic) { return ByteReader(in).Get<uint64_t>() == magic; };
  if (in.ok() && in.left() > 0 && !follows(kLightsMagic) && !follows(kSkyMagic) &&
      !follows(kMirrorsMagic) && !follows(kGlossMagic) && !follows(kMediumMagic) &&
      !follows(kSheetsMagic) && !follows(kGlazingMagic) && !follows(kFluorescenceMagic) &&
      !follows(kBandsMagic)) {
    RETURN_IF_ERROR(GetMaps(in, limits, &scene));
  }
  if (in.ok() && follows(kLightsMagic)) RETURN_IF_ERROR(GetLights(in, limits, &scene));
  if (in.ok() && follows(kSkyMagic)) RETURN_IF_ERROR(TakeSky(in, &scene));
  if (in.ok() && follows(kMirrorsMagic)) RETURN_IF_ERROR(TakeMirrors(in, &scene));
  if (in.ok() && follows(kGlossMagic)) RETURN_IF_ERROR(TakeGloss(in, &scene));
  if (in.ok() && follows(kMediumMagic)) RETURN_IF_ERROR(TakeMedium(in, &scene));
  if (in.ok() && follows(kSheetsMagic)) RETURN_IF_ERROR(TakeSheets(in, &scene));
  if (in.ok() && follows(kGlazingMagic)) {
    RETURN_IF_ERROR(TakeGlazing(in, limits.polygons, &scene.glazing));
  }
  if (in.ok() && follows(kFluorescenceMagic)) RETURN_IF_ERROR(TakeFluorescence(in, &scene));
  if (in.ok() && follows(kBandsMagic)) RETURN_IF_ERROR(TakeBands(in, &scene));
  if (!in.ok() || in.left() > 0) {
    return Error(StatusCode::kDataLoss, "scene: its end is {}", in.ok() ? "too late" : "missing");
  }
  return scene;
}

std::string HashOf(const std::string& encoded_scene) {
  const XXH128_hash_t hash = XXH3_128bits(encoded_scene.data(), encoded_scene.size());
  return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
}

}  // namespace isolux
