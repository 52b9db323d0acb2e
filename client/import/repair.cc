#include "client/import/repair.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "client/import/coordinates.h"
#include "client/import/glass.h"
#include "client/import/prepare.h"
#include "client/import/weld_points.h"
#include "common/scene/triangulate.h"
#include "common/util/random.h"

namespace isolux {
namespace {

struct RepairText {
  const char* text;
  bool defect;  // --strict refuses it
};

RepairText Describe(Repair kind) {
  switch (kind) {
    case Repair::kWelded:
      return {"points joined with others next to them", false};
    case Repair::kZeroArea:
      return {"zero-area faces dropped", true};
    case Repair::kDuplicate:
      return {"duplicate faces dropped", true};
    case Repair::kTwin:
      return {"reversed twins merged into one face", false};
    case Repair::kTwinOtherMaterial:
      return {"reversed twins of another material, fronts kept", false};
    case Repair::kNonPlanar:
      return {"non-planar faces divided into triangles", true};
    case Repair::kSelfCrossing:
      return {"self-crossing faces divided into triangles", true};
    case Repair::kDivided:
      return {"concave or many-cornered faces divided", false};
    case Repair::kMerged:
      return {"pairs of triangles merged into quads", false};
    case Repair::kRegion:
      return {"polygons fewer by dividing flat regions anew", false};
    case Repair::kContact:
      return {"lines of contact cut along", false};
    case Repair::kPenetration:
      return {"penetrations cut along", false};
    case Repair::kCovered:
      return {"covered sides left out", false};
    case Repair::kTJunction:
      return {"corners inside a side of another face (T-junctions)", false};
    case Repair::kSmallContact:
      return {"contacts left uncut: too small to matter", false};
    case Repair::kPieceLimit:
      return {"polygons cut only in part: too many pieces", false};
    case Repair::kReflectance:
      return {"reflectances of 1 or more set to 0.98", true};
    case Repair::kMaterialless:
      return {"faces without a material made grey (0.5)", true};
    case Repair::kNoLibrary:
      return {"material libraries not found, none needed", true};
    case Repair::kRepeatedMaterial:
      return {"materials defined again, the first kept", true};
    case Repair::kMap:
      return {"reflectance maps replaced by their mean", false};
    case Repair::kCoordinates:
      return {"faces without usable texture coordinates: the mean of the map counts", false};
    case Repair::kNoMap:
      return {"maps missing or unreadable, ignored", true};
    case Repair::kEmissionMap:
      return {"emission maps replaced by their mean", false};
    case Repair::kOpacityMap:
      return {"opacity maps ignored", false};
    case Repair::kMirror:
      return {"mirror materials taken as diffuse", false};
    case Repair::kMirrorColour:
      return {"coloured mirrors taken as grey: the mean of their channels", false};
    case Repair::kMirrorShare:
      return {"mirrors that reflect more than arrives: Ks and Kd lowered in proportion", true};
    case Repair::kGlossy:
      return {"glossy materials taken as diffuse", false};
    case Repair::kGlass:
      return {"glass materials taken as diffuse", false};
    case Repair::kSheetShare:
      return {"translucent sheets that pass on more than is left: Td and Kd lowered in proportion",
              true};
    case Repair::kSheetMap:
      return {"maps of what sheets pass on ignored, their factors count", false};
    case Repair::kGlassShare:
      return {"panes that also reflect diffusely: that share counts as absorbed", false};
    case Repair::kUnlit:
      return {"unlit materials taken as diffuse", false};
    case Repair::kLines:
      return {"meshes of points or lines left out", false};
    case Repair::kAnimated:
      return {"animations, skins and morphs left out: the pose at rest counts", false};
    case Repair::kCamera:
      return {"cameras of the file left out; render takes them by --camera FILE", false};
  }
  return {"unknown", true};
}

// A file face with repeated corners and corners on a line taken out.
struct Face {
  uint64_t first = 0;  // in Builder::corners_
  uint32_t count = 0;  // 0: dropped
  uint32_t material = 0;
  uint8_t sides = 0;
};

class Builder {
 public:
  Builder(const SceneFile& file, const std::vector<Glass>& glasses, const ImportOptions& options,
          Scene* scene, RepairLog* log)
      : file_(file), glasses_(glasses), options_(options), scene_(*scene), log_(*log) {}

  void Run() {
    WeldPoints();
    for (uint32_t f = 0; f < file_.faces.size(); ++f) AddFace(f);
    for (uint32_t f = 0; f < faces_.size(); ++f) Shape(f);
    MovePanes(file_, glasses_, &scene_, &log_);
    if (options_.prepare_for_transport && !scene_.polygons.empty()) {
      PrepareForTransport(&scene_, &log_, [&](uint32_t f) { return WhereIs(f); });
    }
    scene_.file_polygon_count = static_cast<uint32_t>(file_.faces.size());
  }

 private:
  void WeldPoints();
  void AddFace(uint32_t f);
  void CleanCorners(std::vector<uint32_t>& corners) const;
  bool IsOnLine(uint32_t a, uint32_t b, uint32_t c) const;
  bool IsNew(uint32_t f, const std::vector<uint32_t>& corners);
  void Shape(uint32_t f);
  void Emit(uint32_t f, std::span<const uint32_t> corners);
  bool SetCoordinates(uint32_t f, std::span<const uint32_t> corners, Polygon* polygon);

  uint8_t SidesOf(uint32_t material) const;
  ConvexPolygon Corners(std::span<const uint32_t> ids) const;
  Vec3 AreaVector(std::span<const uint32_t> ids) const;
  double Deviation(std::span<const uint32_t> ids) const;
  std::span<const uint32_t> CornersOf(const Face& face) const {
    return std::span(corners_).subspan(face.first, face.count);
  }
  std::string WhereIs(uint32_t f) const { return file_.Where(file_.faces[f]); }
  void Note(Repair kind, uint32_t f) {
    log_.Add(kind, [&] { return WhereIs(f); });
  }

  const SceneFile& file_;
  const std::vector<Glass>& glasses_;
  const ImportOptions& options_;
  Scene& scene_;
  RepairLog& log_;
  std::vector<uint32_t> welded_;  // vertex of each point of the file that a face uses
  std::vector<Face> faces_;       // by number in the file
  std::vector<uint32_t> corners_;
  // Faces by hash of their outline, and of the outline of twins that were merged into them.
  struct Outline {
    uint32_t face = 0;
    bool reversed = false;  // the outline is that of the merged twin
  };
  std::unordered_multimap<uint64_t, Outline> outlines_;
};

// Equal points become one vertex, and so do near ones where the scene is prepared; the centre of
// the box of all is subtracted before the unit is applied, both in double.
void Builder::WeldPoints() {
  std::vector<bool> used(file_.points.size(), false);
  for (const uint32_t p : file_.corners) used[p] = true;
  Bounds3 bounds;
  for (size_t p = 0; p < used.size(); ++p) {
    if (used[p]) bounds.Add(file_.points[p]);
  }
  const Vec3 centre = bounds.Centre();
  scene_.origin_m = centre * scene_.metres_per_unit;
  const auto hash = [](const Vec3& v) {
    return Hash(std::bit_cast<uint64_t>(v.x), std::bit_cast<uint64_t>(v.y),
                std::bit_cast<uint64_t>(v.z));
  };
  std::unordered_map<Vec3, uint32_t, decltype(hash)> vertex_of(used.size(), hash);
  welded_.assign(used.size(), kNoVertex);
  for (size_t p = 0; p < used.size(); ++p) {
    if (!used[p]) continue;
    const Vec3 point = (file_.points[p] - centre) * scene_.metres_per_unit + 0.0;  // no -0
    const auto next = static_cast<uint32_t>(scene_.vertices.size());
    const auto [at, is_new] = vertex_of.emplace(point, next);
    if (is_new) scene_.vertices.push_back(point);
    welded_[p] = at->second;
  }
  if (!options_.prepare_for_transport) return;
  const uint64_t joined = JoinNearPoints(file_, &welded_, &scene_.vertices);
  log_.Add(Repair::kWelded, joined, [&] { return file_.path; });
}

uint8_t Builder::SidesOf(uint32_t material) const {
  uint8_t sides = kFrontTakesPart;
  const bool both = material < file_.materials.size() && file_.materials[material].double_sided;
  const bool sheet = scene_.materials[material].transmittance != Rgb(0.0);
  if (!options_.reflect_front || both || sheet) sides |= kBackTakesPart;
  if (Sum(scene_.materials[material].exitance) > 0) {
    sides |= kFrontEmits;
    if (options_.emit_both || both) sides |= kBackEmits | kBackTakesPart;
  }
  return sides;
}

ConvexPolygon Builder::Corners(std::span<const uint32_t> ids) const {
  ConvexPolygon polygon;
  polygon.count = static_cast<int>(ids.size());
  for (size_t i = 0; i < ids.size(); ++i) polygon.v[i] = scene_.vertices[ids[i]];
  return polygon;
}

Vec3 Builder::AreaVector(std::span<const uint32_t> ids) const {
  Vec3 sum(0.0);
  const Vec3& first = scene_.vertices[ids[0]];
  for (size_t i = 1; i + 1 < ids.size(); ++i) {
    sum += glm::cross(scene_.vertices[ids[i]] - first, scene_.vertices[ids[i + 1]] - first);
  }
  return 0.5 * sum;
}

// Largest distance of a corner from the plane through the mean of the corners, over the extent.
double Builder::Deviation(std::span<const uint32_t> ids) const {
  const Vec3 normal = glm::normalize(AreaVector(ids));
  Vec3 mean(0.0);
  Bounds3 bounds;
  for (const uint32_t id : ids) {
    mean += scene_.vertices[id] / static_cast<double>(ids.size());
    bounds.Add(scene_.vertices[id]);
  }
  double largest = 0;
  for (const uint32_t id : ids) {
    largest = std::max(largest, std::abs(glm::dot(scene_.vertices[id] - mean, normal)));
  }
  return largest / bounds.Diagonal();
}

bool Builder::IsOnLine(uint32_t a, uint32_t b, uint32_t c) const {
  const Vec3 in = scene_.vertices[b] - scene_.vertices[a];
  const Vec3 out = scene_.vertices[c] - scene_.vertices[b];
  const Vec3 cross = glm::cross(in, out);
  return glm::dot(cross, cross) <= 1e-18 * glm::dot(in, in) * glm::dot(out, out);
}

void Builder::CleanCorners(std::vector<uint32_t>& corners) const {
  bool changed = true;
  while (changed && corners.size() > 2) {
    changed = false;
    for (size_t i = 0; i < corners.size() && corners.size() > 2;) {
      const uint32_t before = corners[i == 0 ? corners.size() - 1 : i - 1];
      const uint32_t after = corners[i + 1 == corners.size() ? 0 : i + 1];
      const bool needless = corners[i] == after || before == after ||
                            (corners.size() > 3 && IsOnLine(before, corners[i], after));
      if (!needless) {
        ++i;
        continue;
      }
      corners.erase(corners.begin() + static_cast<ptrdiff_t>(i));
      changed = true;
    }
  }
}

void Builder::AddFace(uint32_t f) {
  const FileFace& from = file_.faces[f];
  Face& face = faces_.emplace_back();
  std::vector<uint32_t> corners;
  for (uint32_t i = 0; i < from.count; ++i)
    corners.push_back(welded_[file_.corners[from.first + i]]);
  CleanCorners(corners);
  // The same bound as HasArea's, for any number of corners.
  double longest2 = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 side =
        scene_.vertices[corners[i]] - scene_.vertices[corners[(i + 1) % corners.size()]];
    longest2 = std::max(longest2, glm::dot(side, side));
  }
  const double area = corners.size() > 2 ? glm::length(AreaVector(corners)) : 0.0;
  if (!(area > kNoArea * longest2 && area > 1e-200)) return Note(Repair::kZeroArea, f);
  face.material =
      from.material == kNoMaterial ? static_cast<uint32_t>(file_.materials.size()) : from.material;
  face.sides = SidesOf(face.material);
  if (from.material == kNoMaterial) Note(Repair::kMaterialless, f);
  if (!IsNew(f, corners)) return;
  face.first = corners_.size();
  face.count = static_cast<uint32_t>(corners.size());
  corners_.insert(corners_.end(), corners.begin(), corners.end());
}

// The same outline whichever corner it starts at: the least of the rotations that begin with the
// least corner.
std::vector<uint32_t> Canonical(const std::vector<uint32_t>& corners, bool reversed) {
  std::vector<uint32_t> loop(corners);
  if (reversed) std::reverse(loop.begin(), loop.end());
  const uint32_t least = *std::min_element(loop.begin(), loop.end());
  std::vector<uint32_t> best;
  for (size_t i = 0; i < loop.size(); ++i) {
    if (loop[i] != least) continue;
    std::vector<uint32_t> turned(loop.begin() + static_cast<ptrdiff_t>(i), loop.end());
    turned.insert(turned.end(), loop.begin(), loop.begin() + static_cast<ptrdiff_t>(i));
    if (best.empty() || turned < best) best = std::move(turned);
  }
  return best;
}

uint64_t HashOfOutline(const std::vector<uint32_t>& loop) {
  uint64_t hash = loop.size();
  for (const uint32_t id : loop) hash = Hash(hash, id);
  return hash;
}

// Drops duplicates and joins reversed twins; true where the face is to be kept.
bool Builder::IsNew(uint32_t f, const std::vector<uint32_t>& corners) {
  const auto find = [&](const std::vector<uint32_t>& loop) -> const Outline* {
    const auto [begin, end] = outlines_.equal_range(HashOfOutline(loop));
    for (auto it = begin; it != end; ++it) {
      const Outline& outline = it->second;
      const auto of_face = CornersOf(faces_[outline.face]);
      if (Canonical({of_face.begin(), of_face.end()}, outline.reversed) == loop) return &outline;
    }
    return nullptr;
  };
  const std::vector<uint32_t> loop = Canonical(corners, false);
  if (find(loop) != nullptr) {
    Note(Repair::kDuplicate, f);
    return false;
  }
  const Outline* twin = find(Canonical(corners, true));
  const uint32_t first = twin != nullptr ? twin->face : f;
  const bool alike = twin != nullptr && faces_[first].material == faces_[f].material;
  const bool merge = alike && options_.prepare_for_transport;
  outlines_.emplace(HashOfOutline(loop), Outline{merge ? first : f, merge});
  if (twin == nullptr) return true;
  if (merge) {  // the twin's front is the first one's back
    faces_[first].sides |= kBackTakesPart;
    if ((faces_[f].sides & kFrontEmits) != 0) faces_[first].sides |= kBackEmits;
    Note(Repair::kTwin, f);
    return false;
  }
  faces_[first].sides &= kFrontTakesPart | kFrontEmits;
  faces_[f].sides &= kFrontTakesPart | kFrontEmits;
  if (!alike) Note(Repair::kTwinOtherMaterial, f);
  return true;
}

void Builder::Shape(uint32_t f) {
  const auto ids = CornersOf(faces_[f]);
  if (ids.empty()) return;
  if (ids.size() == 3) return Emit(f, ids);
  if (ids.size() == 4) {
    const ConvexPolygon quad = Corners(ids);
    if (IsPlanar(quad) && IsConvex(quad)) return Emit(f, ids);
  }
  const bool planar = Deviation(ids) <= kPlanarTolerance;
  std::vector<Vec3> points;
  for (const uint32_t id : ids) points.push_back(scene_.vertices[id]);
  const Triangulation division = Triangulate(points, ids);
  Note(!division.simple ? Repair::kSelfCrossing
       : planar         ? Repair::kDivided
                        : Repair::kNonPlanar,
       f);
  for (const auto& t : division.triangles) {
    const std::array<uint32_t, 3> triangle{ids[t[0]], ids[t[1]], ids[t[2]]};
    if (HasArea(Corners(triangle))) Emit(f, triangle);
  }
}

void Builder::Emit(uint32_t f, std::span<const uint32_t> corners) {
  Polygon polygon;
  std::copy(corners.begin(), corners.end(), polygon.vertices.begin());
  polygon.material = faces_[f].material;
  polygon.file_polygon = f;
  polygon.sides = faces_[f].sides;
  if (!SetCoordinates(f, corners, &polygon)) {
    if (corners.size() == 4) {  // the map bends along a diagonal
      Emit(f, std::array{corners[0], corners[1], corners[2]});
      return Emit(f, std::array{corners[0], corners[2], corners[3]});
    }
    Note(Repair::kCoordinates, f);
  }
  scene_.polygons.push_back(polygon);
}

// False where the material has maps, and the polygon no coordinates for them.
bool Builder::SetCoordinates(uint32_t f, std::span<const uint32_t> corners, Polygon* polygon) {
  const Material& material = scene_.materials[polygon->material];
  if (material.reflectance_map.texture == kNoTexture &&
      material.exitance_map.texture == kNoTexture) {
    return true;
  }
  const FileFace& from = file_.faces[f];
  std::array<glm::dvec2, 4> texture;
  for (size_t k = 0; k < corners.size(); ++k) {
    uint32_t i = 0;
    while (i < from.count && welded_[file_.corners[from.first + i]] != corners[k]) ++i;
    const uint32_t number =
        i < from.count ? file_.corner_coordinates[from.first + i] : kNoCoordinates;
    if (number == kNoCoordinates) return false;
    texture[k] = file_.coordinates[number];
  }
  const ConvexPolygon shape = Corners(corners);
  const auto fit = FitCoordinates(shape, std::span(texture).first(corners.size()));
  if (!fit || !IsUsable(shape, *fit, material)) return false;
  polygon->coordinates = static_cast<uint32_t>(scene_.coordinates.size());
  scene_.coordinates.push_back(*fit);
  return true;
}

}  // namespace

const char* ToText(Repair kind) { return Describe(kind).text; }

RepairReport RepairLog::Report() const {
  RepairReport report;
  for (size_t kind = 0; kind < kKinds; ++kind) {
    if (entries_[kind].count == 0) continue;
    report.entries.push_back(
        {ToText(static_cast<Repair>(kind)), entries_[kind].count, entries_[kind].example});
  }
  return report;
}

Status RepairLog::CheckStrict() const {
  for (size_t kind = 0; kind < kKinds; ++kind) {
    const RepairText text = Describe(static_cast<Repair>(kind));
    if (entries_[kind].count == 0 || !text.defect) continue;
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: {} ({} in all); mend the file, or leave out --strict",
                      entries_[kind].example, text.text, entries_[kind].count);
  }
  return {};
}

Status BuildPolygons(const SceneFile& file, const std::vector<Glass>& glasses,
                     const ImportOptions& options, Scene* scene, RepairLog* log) {
  Builder(file, glasses, options, scene, log).Run();
  if (scene->polygons.empty() && scene->glazing.exists()) {
    return MakeStatus(StatusCode::kInvalidArgument,
                      "{}: all faces are of clear glass; give some of them an opaque material",
                      file.path);
  }
  if (scene->polygons.empty()) {
    return MakeStatus(StatusCode::kInvalidArgument, "{}: no face has any area", file.path);
  }
  return {};
}

}  // namespace isolux
