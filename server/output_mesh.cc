#include "server/output_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "common/hierarchy/element.h"
#include "server/output_maps.h"
#include "server/output_refinement.h"
#include "server/output_sheets.h"
#include "server/weld.h"
#include "server/weld_groups.h"

namespace isolux {
namespace {

// Corners as one vertex: this share of the scene's extent. Far below any element's size, far above
// what rounding moves a midpoint.
constexpr double kWeldTolerance = 1e-6;
// What links in doubt may bring a leaf, over what was gathered there, at which both count the same.
constexpr double kEvenDoubt = 0.5;

using Element = OutputElement;

Channels Radiosity(const Optics& optics, const Channels& irradiance) {
  Channels result{};
  for (int c = 0; c < 3; ++c) {
    result[c] = static_cast<float>(optics.exitance[c] + optics.reflectance[c] * irradiance[c]);
  }
  return result;
}

void AddPassedOn(const Rgb& transmittance, const Channels& behind, Channels* radiosity) {
  for (int c = 0; c < 3; ++c) {
    (*radiosity)[c] += static_cast<float>(transmittance[c] * behind[c]);
  }
}

void AddReradiated(const Reradiation& reradiation, const Channels& irradiance,
                   Channels* radiosity) {
  const Rgb out = reradiation.Of({irradiance[0], irradiance[1], irradiance[2]});
  for (int c = 0; c < 3; ++c) (*radiosity)[c] += static_cast<float>(out[c]);
}

// Elements → vertices and faces.
class Assembly {
 public:
  // `groups`: FindWeldGroups.
  Assembly(const Hierarchy& hierarchy, std::span<const uint32_t> groups, const Snapshot& snapshot,
           const OutputMeshOptions& options, const std::vector<Element>& elements)
      : hierarchy_(hierarchy),
        groups_(groups),
        sheets_(options.sheets),
        fluorescence_(options.fluorescence),
        leaves_(snapshot.leaves),
        elements_(elements),
        behind_(ElementsBehind(options.sheets, elements_)),
        welder_(kWeldTolerance * hierarchy.extent_m(), hierarchy.clusters()[0].bounds.low,
                elements_.size() + elements_.size() / 2 + 16) {}

  PatchFile Run() {
    Weld();
    const std::vector<TVertex> t_vertices = FindTVertices(welder_, corners_);
    PatchFile file;
    AddVertices(&file);
    AddFaces(t_vertices, &file);
    return file;
  }

 private:
  // The vertices of each element's corners, and the sums of what was gathered there.
  void Weld() {
    corners_.assign(elements_.size(), {kNoCorner, kNoCorner, kNoCorner, kNoCorner});
    for (size_t e = 0; e < elements_.size(); ++e) {
      const Element& element = elements_[e];
      const uint32_t surface = element.id.surface;
      const ConvexPolygon shape = ElementGeometry(hierarchy_.geometry(surface), element.id.path);
      for (int k = 0; k < shape.count; ++k) {
        const uint32_t vertex = welder_.Vertex(shape.v[k], groups_[surface]);
        corners_[e][k] = vertex;
        if (vertex == sums_.size()) sums_.push_back({{}, {}, 0, surface, {}});
        for (int c = 0; c < 3; ++c) sums_[vertex].irradiance[c] += element.irradiance[k][c];
        if (const Element* behind = Behind(e)) {
          const Channels& irradiance = behind->irradiance[CornerBehind(shape.count, k)];
          for (int c = 0; c < 3; ++c) sums_[vertex].behind[c] += irradiance[c];
        }
        ++sums_[vertex].count;
        if (!hierarchy_.maps().Varies(hierarchy_.surfaces()[surface].polygon)) continue;
        const Optics optics = hierarchy_.maps().AtCorner(hierarchy_.surfaces()[surface], shape, k);
        sums_[vertex].optics.reflectance += optics.reflectance;
        sums_[vertex].optics.exitance += optics.exitance;
      }
    }
  }

  void AddVertices(PatchFile* file) const {
    const Scene& scene = hierarchy_.scene();
    file->vertices.resize(sums_.size());
    for (size_t v = 0; v < sums_.size(); ++v) {
      PatchVertex& vertex = file->vertices[v];
      vertex.position = (welder_.positions()[v] + scene.origin_m) / scene.metres_per_unit;
      for (int c = 0; c < 3; ++c) {
        vertex.irradiance[c] = static_cast<float>(sums_[v].irradiance[c] / sums_[v].count);
      }
      vertex.radiosity = Radiosity(OpticsOf(sums_[v]), vertex.irradiance);
      AddReradiated(fluorescence_.Of(sums_[v].surface), vertex.irradiance, &vertex.radiosity);
      if (sheets_.empty()) continue;
      Channels behind{};
      for (int c = 0; c < 3; ++c) {
        behind[c] = static_cast<float>(sums_[v].behind[c] / sums_[v].count);
      }
      AddPassedOn(sheets_.TransmittanceOf(sums_[v].surface), behind, &vertex.radiosity);
    }
  }

  void AddFaces(const std::vector<TVertex>& t_vertices, PatchFile* file) const {
    file->faces.reserve(elements_.size());
    const std::vector<Channels> irradiance = MeanIrradiances();
    size_t t = 0;
    for (size_t e = 0; e < elements_.size(); ++e) {
      PatchFace face;
      face.vertices = VertexList(e, t_vertices, &t);
      if (face.vertices.size() < 3) continue;  // thinner than the tolerance
      FillFace(elements_[e], irradiance[e], &face);
      AddReradiated(fluorescence_.Of(face.surface), face.irradiance, &face.radiosity);
      if (Behind(e) != nullptr) {
        AddPassedOn(sheets_.TransmittanceOf(face.surface), irradiance[behind_[e]], &face.radiosity);
      }
      file->faces.push_back(std::move(face));
    }
  }

  // Of each element.
  std::vector<Channels> MeanIrradiances() const {
    std::vector<Channels> irradiance(elements_.size());
    for (size_t begin = 0; begin < elements_.size();) {
      size_t end = begin;
      while (end < elements_.size() && elements_[end].leaf == elements_[begin].leaf) ++end;
      const Means means = MeansOf({&elements_[begin], end - begin});
      for (; begin < end; ++begin) {
        const Element& element = elements_[begin];
        const int corners = hierarchy_.geometry(element.id.surface).count;
        for (int c = 0; c < 3; ++c) {
          irradiance[begin][c] = static_cast<float>(
              means.constant[c] + means.scale[c] * MeanOfCorners(element, corners, c));
        }
      }
    }
    return irradiance;
  }

  // The same piece on the other side of a sheet; null where there is none.
  const Element* Behind(size_t element) const {
    const bool none = behind_.empty() || behind_[element] == TranslucentSheets::kNone;
    return none ? nullptr : &elements_[behind_[element]];
  }

  // Corners and T-vertices in order; corners that became one vertex stand once.
  std::vector<uint32_t> VertexList(size_t element, const std::vector<TVertex>& t_vertices,
                                   size_t* t) const {
    std::vector<uint32_t> list;
    for (uint32_t k = 0; k < 4 && corners_[element][k] != kNoCorner; ++k) {
      if (list.empty() || list.back() != corners_[element][k]) list.push_back(corners_[element][k]);
      for (; *t < t_vertices.size() && t_vertices[*t].face == element && t_vertices[*t].side == k;
           ++*t) {
        list.push_back(t_vertices[*t].vertex);
      }
    }
    while (list.size() > 1 && list.back() == list.front()) list.pop_back();
    return list;
  }

  static double MeanOfCorners(const Element& element, int corners, int channel) {
    double sum = 0;
    for (int k = 0; k < corners; ++k) sum += element.irradiance[k][channel];
    return sum / corners;
  }

  // How what was gathered over a part of a leaf becomes the part's mean.
  struct Means {
    std::array<double, 3> scale{1, 1, 1};
    std::array<double, 3> constant{};  // W/m²
  };

  // Where transport is sure of a leaf, the leaf keeps its power; where it is in doubt, as behind a
  // small hole, the means are those of what was gathered. How sure it is does not depend on which
  // of the two found more: what either scatters must not become a bias.
  Means MeansOf(std::span<const Element> parts) const {
    const LeafRecord& leaf = leaves_[parts.front().leaf];
    const int corners = hierarchy_.geometry(leaf.id.surface).count;
    std::array<double, 3> gathered{};
    double area = 0;
    for (const Element& part : parts) {
      // Relative to the leaf: parts of one level have nearly, but not always, the same area.
      const double of_part =
          ElementGeometry(hierarchy_.geometry(part.id.surface), part.id.path).Area();
      for (int c = 0; c < 3; ++c) gathered[c] += of_part * MeanOfCorners(part, corners, c);
      area += of_part;
    }
    const double doubt = leaf.doubt * area / kEvenDoubt;
    double sure = gathered[0] + gathered[1] + gathered[2];
    // In the dark the points may be too few to tell.
    if (!(sure > 0)) {
      sure = area * (leaf.irradiance[0] + leaf.irradiance[1] + leaf.irradiance[2]);
    }
    const double trust = sure > 0 ? 1 / (1 + (doubt / sure) * (doubt / sure)) : 0.0;
    Means means;
    for (int c = 0; c < 3; ++c) {
      if (!(leaf.irradiance[c] > 0)) continue;  // too dim for any link
      if (gathered[c] > 0) {
        means.scale[c] += trust * (leaf.irradiance[c] * area / gathered[c] - 1);
      } else {
        means.constant[c] = trust * leaf.irradiance[c];
      }
    }
    return means;
  }

  void FillFace(const Element& element, const Channels& irradiance, PatchFace* face) const {
    const LeafRecord& leaf = leaves_[element.leaf];
    const uint32_t s = element.id.surface;
    const Surface& surface = hierarchy_.surfaces()[s];
    const Optics optics =
        hierarchy_.maps().Over(surface, ElementGeometry(hierarchy_.geometry(s), element.id.path));
    face->irradiance = irradiance;
    for (int c = 0; c < 3; ++c) face->emission[c] = static_cast<float>(optics.exitance[c]);
    face->radiosity = Radiosity(optics, face->irradiance);
    face->error = leaf.error;
    face->polygon = hierarchy_.scene().polygons[surface.polygon].file_polygon;
    face->surface = s;
    face->side = static_cast<uint8_t>(surface.side);
    face->path = element.id.path;
  }

  struct VertexSum {
    std::array<double, 3> irradiance{};
    std::array<double, 3> behind{};  // the same on the other side of a sheet
    uint32_t count = 0;
    uint32_t surface = 0;  // the first; all of a group reflect and emit alike
    Optics optics;         // sums over the elements, where a map varies them
  };

  Optics OpticsOf(const VertexSum& sum) const {
    const Surface& surface = hierarchy_.surfaces()[sum.surface];
    Optics optics;
    const bool varies = hierarchy_.maps().Varies(surface.polygon);
    optics.reflectance =
        varies ? sum.optics.reflectance / static_cast<double>(sum.count) : surface.reflectance;
    optics.exitance =
        varies ? sum.optics.exitance / static_cast<double>(sum.count) : surface.exitance;
    return optics;
  }

  const Hierarchy& hierarchy_;
  std::span<const uint32_t> groups_;
  const TranslucentSheets& sheets_;
  const Fluorescence& fluorescence_;
  const std::vector<LeafRecord>& leaves_;
  const std::vector<Element>& elements_;
  std::vector<uint32_t> behind_;  // of each element, the same piece of the other side of a sheet
  Welder welder_;
  std::vector<std::array<uint32_t, 4>> corners_;  // vertices of each element's corners
  std::vector<VertexSum> sums_;                   // of each vertex
};

}  // namespace

Result<OutputMesh> BuildOutputMesh(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                   const OutputMeshOptions& options, const GatherFunction& gather) {
  std::vector<uint32_t> all(snapshot.leaves.size());
  std::iota(all.begin(), all.end(), 0);
  ASSIGN_OR_RETURN(OutputElements output, RefineOutput(hierarchy, snapshot, all, options, gather));
  DivideByMaps(hierarchy, options.max_elements, &output.elements);
  DivideSheetsAlike(hierarchy, options.sheets, &output.elements);
  OutputMesh mesh;
  mesh.weld_groups = FindWeldGroups(hierarchy);
  mesh.patch = Assembly(hierarchy, mesh.weld_groups, snapshot, options, output.elements).Run();
  mesh.interpolation_error = output.interpolation_error;
  mesh.points = std::move(output.points);
  mesh.elements = std::move(output.elements);
  return mesh;
}

Result<PatchFile> BuildAgain(const OutputMesh& mesh, const Hierarchy& of_light,
                             const Snapshot& snapshot, const OutputMeshOptions& options,
                             const GatherFunction& gather) {
  std::vector<Element> elements = mesh.elements;
  RETURN_IF_ERROR(GatherAgain(mesh.points, of_light, gather, &elements));
  PatchFile patch = Assembly(of_light, mesh.weld_groups, snapshot, options, elements).Run();
  if (patch.vertices.size() == mesh.patch.vertices.size() &&
      patch.faces.size() == mesh.patch.faces.size()) {
    return patch;
  }
  return Error(StatusCode::kInternal, "the mesh of a group of bands has other vertices");
}

}  // namespace isolux
