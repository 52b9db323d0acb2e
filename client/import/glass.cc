#include "client/import/glass.h"

#include <algorithm>
#include <cmath>

#include "common/scene/box_tree.h"

namespace isolux {
namespace {

// Faces of one material this near to each other, or nearer than this share of the larger's size,
// are those of a slab: sheets of glass in windows and furniture are up to two centimetres thick.
constexpr double kThickest_m = 0.04, kThickestOfSize = 0.1;
// Cosine between planes of a slab.
constexpr double kParallel = 0.9999;

bool Holds(const ConvexPolygon& polygon, const Vec3& normal, const Vec3& point) {
  for (int i = 0; i < polygon.count; ++i) {
    const Vec3 along = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
    if (glm::dot(glm::cross(along, point - polygon.v[i]), normal) < 0) return false;
  }
  return true;
}

// Marks the panes that face another one across a slab.
void FindSlabs(std::vector<Pane>* panes) {
  std::vector<ConvexPolygon> shapes;
  std::vector<Vec3> normals;
  std::vector<double> sizes;
  std::vector<Bounds3> boxes;
  for (const Pane& pane : *panes) {
    shapes.push_back(ShapeOf(pane));
    normals.push_back(shapes.back().Normal());
    Bounds3 box;
    for (int i = 0; i < shapes.back().count; ++i) box.Add(shapes.back().v[i]);
    boxes.push_back(box);
    sizes.push_back(box.Diagonal());
  }
  const BoxTree tree(boxes);
  for (size_t p = 0; p < panes->size(); ++p) {
    const Vec3 centre = shapes[p].Centroid();
    const double reach = std::min(kThickest_m, kThickestOfSize * sizes[p]);
    Bounds3 around;
    around.Add(centre);
    tree.ForEachOverlap(Widened(around, reach), [&](uint32_t q) {
      if (q == p || (*panes)[q].glass != (*panes)[p].glass) return;
      if (std::abs(glm::dot(normals[p], normals[q])) < kParallel) return;
      const double apart = glm::dot(normals[q], centre - shapes[q].v[0]);
      if (std::abs(apart) > reach || std::abs(apart) < 1e-6 * sizes[p]) return;
      if (Holds(shapes[q], normals[q], centre - apart * normals[q])) (*panes)[p].is_half = true;
    });
  }
}

}  // namespace

bool IsPane(const FileMaterial& m) {
  if (!m.glass || m.opacity_map || Sum(m.radiance) > 0 || Sum(m.transmittance) > 0) return false;
  if (!(Sum(m.clear) > 0) || Sum(m.scattered) > Sum(m.clear)) return false;
  constexpr double kRounding = 1e-6;
  for (int c = 0; c < 3; ++c) {
    if (m.clear[c] + m.scattered[c] > 1 + kRounding) return false;
  }
  return true;
}

void MovePanes(const SceneFile& file, const std::vector<Glass>& glasses, Scene* scene,
               RepairLog* log) {
  std::vector<uint32_t> glass_of(file.materials.size(), kNoMaterial);
  Glazing& glazing = scene->glazing;
  std::erase_if(scene->polygons, [&](const Polygon& polygon) {
    if (polygon.material >= file.materials.size()) return false;
    const FileMaterial& material = file.materials[polygon.material];
    if (!IsPane(material)) return false;
    uint32_t& glass = glass_of[polygon.material];
    if (glass == kNoMaterial) {
      glass = static_cast<uint32_t>(glazing.glasses.size());
      glazing.glasses.push_back(glasses[polygon.material]);
      if (Sum(material.scattered) > 0)
        log->Add(Repair::kGlassShare, [&] { return material.where; });
    }
    Pane& pane = glazing.panes.emplace_back();
    pane.count = static_cast<uint32_t>(polygon.vertex_count());
    for (uint32_t i = 0; i < pane.count; ++i) {
      pane.corners[i] = scene->vertices[polygon.vertices[i]];
    }
    pane.glass = glass;
    return true;
  });
  FindSlabs(&glazing.panes);
}

}  // namespace isolux
