#include "server/output_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "common/hierarchy/element.h"
#include "server/output_maps.h"
#include "server/weld.h"
#include "server/weld_groups.h"

namespace isolux {
namespace {

// Corners as one vertex: this share of the scene's extent. Far below any element's size, far above
// what rounding moves a midpoint.
constexpr double kWeldTolerance = 1e-6;
// Corners of one leaf's elements as one point: what rounding moves a midpoint.
constexpr double kSameCorner = 1e-9;
// A tolerance never goes below that of this share of the mean irradiance: dark corners are not
// worth points.
constexpr double kDarkShare = 0.05;
// The accuracy is that of the mean; a single bend may be this much larger. Against a tolerance of
// one accuracy the Cornell box at 5 % takes 42 % fewer elements, and its error grows from 2.64
// to 2.70 %.
constexpr double kBend = 2;
// When a leaf is divided, before anything is known of its inside. A field that varies by r over a
// leaf bends by about r/8 (a parabola) to r/4 (a corner) at its middle.
constexpr double kContrast = 4;    // range of its corners, in tolerances
constexpr double kMeanOffset = 2;  // its mean irradiance against the mean of its corners, the same
constexpr double kLargeLeaf = 1.0 / 12;  // longest side over the scene's extent
// Where scaling the parts of a leaf to the leaf's power takes a factor outside this, gathering and
// transport disagree too much for it to mean anything.
constexpr double kLeastScale = 0.5, kLargestScale = 2;

using Element = OutputElement;

// An element to be gathered: what interpolation over the one it is cut from says of its corners.
struct Candidate {
  NodeId id;
  uint32_t leaf = 0;
  float tolerance = 0;  // W/m², sum of channels
  std::array<Channels, 4> expected{};
};

double Sum(const Channels& c) { return static_cast<double>(c[0]) + c[1] + c[2]; }

double Difference(const Channels& a, const Channels& b) {
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += std::abs(static_cast<double>(a[c]) - b[c]);
  return sum;
}

// The waves: which elements there are, and what was gathered at their corners.
//
// A division cuts an element twice, into four: one cut would show a bend in one direction only.
class Refinement {
 public:
  Refinement(const Hierarchy& hierarchy, const Snapshot& snapshot, const OutputMeshOptions& options,
             const GatherFunction& gather)
      : hierarchy_(hierarchy),
        leaves_(snapshot.leaves),
        options_(options),
        gather_(gather),
        points_(kSameCorner * hierarchy.extent_m(), hierarchy.clusters()[0].bounds.low,
                2 * leaves_.size() + 16) {}

  // Elements of these leaves by id, without surfaces that have no light.
  Result<std::vector<Element>> Run(const std::vector<uint32_t>& leaves) {
    FindMean();
    std::vector<Candidate> wave;
    for (const uint32_t i : leaves) wave.push_back({leaves_[i].id, i, 0, {}});
    std::vector<double> bends;
    ASSIGN_OR_RETURN(std::vector<Element> pieces, Gather(wave, nullptr));
    RemoveDarkSurfaces(&pieces);
    for (const Element& piece : pieces) bends.push_back(LeafBend(piece));
    std::vector<Element> done;
    for (int w = 1; w < options_.waves && !pieces.empty(); ++w) {
      wave = Divide(pieces, bends, &done);
      ASSIGN_OR_RETURN(pieces, Gather(wave, &bends));
    }
    done.insert(done.end(), pieces.begin(), pieces.end());
    std::sort(done.begin(), done.end(),
              [](const Element& a, const Element& b) { return a.id < b.id; });
    return done;
  }

 private:
  // Mean over all sides that take part, sum of channels.
  void FindMean() {
    double power = 0, area = 0;
    for (const LeafRecord& leaf : leaves_) {
      const double part =
          hierarchy_.surface_area_m2(leaf.id.surface) * std::ldexp(1.0, -leaf.id.level());
      power += part * (leaf.irradiance[0] + leaf.irradiance[1] + leaf.irradiance[2]);
      area += part;
    }
    mean_ = area > 0 ? power / area : 0;
  }

  double Tolerance(double irradiance) const {
    return kBend * options_.accuracy * std::max(irradiance, kDarkShare * mean_);
  }

  // Gathers a wave. `bends`: how far each differs from what was expected, in tolerances. Corners
  // that an element of the leaf has had before are known.
  Result<std::vector<Element>> Gather(const std::vector<Candidate>& wave,
                                      std::vector<double>* bends) {
    std::vector<NodeId> ids;
    std::vector<uint8_t> wanted;
    std::vector<std::array<uint32_t, 4>> vertices(wave.size());
    for (size_t i = 0; i < wave.size(); ++i) {
      uint8_t corners = 0;
      const ConvexPolygon shape =
          ElementGeometry(hierarchy_.geometry(wave[i].id.surface), wave[i].id.path);
      for (int k = 0; k < shape.count; ++k) {
        vertices[i][k] = points_.Vertex(shape.v[k], wave[i].leaf);
        if (vertices[i][k] < irradiance_.size()) continue;
        irradiance_.emplace_back();
        corners |= static_cast<uint8_t>(1U << k);
      }
      if (corners == 0) continue;
      ids.push_back(wave[i].id);
      wanted.push_back(corners);
    }
    ASSIGN_OR_RETURN(
        const std::vector<double> values,
        ids.empty() ? Result<std::vector<double>>(std::vector<double>{}) : gather_(ids, wanted));
    if (values.size() != 12 * ids.size()) {
      return Error(StatusCode::kInternal, "gathered {} values at the corners of {} elements",
                   values.size(), ids.size());
    }
    for (size_t i = 0, asked = 0; i < wave.size() && asked < ids.size(); ++i) {
      if (!(wave[i].id == ids[asked])) continue;
      for (int k = 0; k < 4; ++k) {
        if ((wanted[asked] >> k & 1) == 0) continue;
        for (int c = 0; c < 3; ++c) {
          const double value = values[12 * asked + 3 * k + c];
          irradiance_[vertices[i][k]][c] = static_cast<float>(
              std::isfinite(value) ? std::max(0.0, value) : leaves_[wave[i].leaf].irradiance[c]);
        }
      }
      ++asked;
    }
    std::vector<Element> elements(wave.size());
    if (bends != nullptr) bends->assign(wave.size(), 0);
    for (size_t i = 0; i < wave.size(); ++i) {
      elements[i] = {wave[i].id, wave[i].leaf, {}};
      const int corners = hierarchy_.geometry(wave[i].id.surface).count;
      for (int k = 0; k < corners; ++k) {
        elements[i].irradiance[k] = irradiance_[vertices[i][k]];
        if (bends == nullptr) continue;
        const double off = Difference(elements[i].irradiance[k], wave[i].expected[k]);
        if (off > 0) (*bends)[i] = std::max((*bends)[i], off / wave[i].tolerance);
      }
    }
    return elements;
  }

  // A surface on which nothing arrives and that does not emit is left out.
  void RemoveDarkSurfaces(std::vector<Element>* pieces) const {
    std::vector<bool> lit(hierarchy_.surfaces().size(), false);
    for (const Element& piece : *pieces) {
      double light = isolux::Sum(hierarchy_.surfaces()[piece.id.surface].exitance);
      for (int c = 0; c < 3; ++c) light += leaves_[piece.leaf].irradiance[c];
      for (const Channels& corner : piece.irradiance) light += Sum(corner);
      if (light > 0) lit[piece.id.surface] = true;
    }
    std::erase_if(*pieces, [&](const Element& piece) { return !lit[piece.id.surface]; });
  }

  // Whether a leaf may bend, in tolerances (above 1: likely), from its corners, mean and size.
  double LeafBend(const Element& piece) const {
    const int corners = hierarchy_.geometry(piece.id.surface).count;
    const LeafRecord& leaf = leaves_[piece.leaf];
    double low = INFINITY, high = 0, offset = 0, total = 0;
    for (int k = 0; k < corners; ++k) {
      low = std::min(low, Sum(piece.irradiance[k]));
      high = std::max(high, Sum(piece.irradiance[k]));
    }
    for (int c = 0; c < 3; ++c) {
      double mean = 0;
      for (int k = 0; k < corners; ++k) mean += piece.irradiance[k][c] / corners;
      offset += std::abs(mean - leaf.irradiance[c]);
      total += leaf.irradiance[c];
    }
    if (!(high > 0) && !(total > 0)) return 0;  // in the dark: nothing to show
    const double tolerance = Tolerance(0.5 * (low + high));
    const ConvexPolygon shape =
        ElementGeometry(hierarchy_.geometry(piece.id.surface), piece.id.path);
    const int i = LongestSide(shape);
    const double size = glm::length(shape.v[(i + 1) % shape.count] - shape.v[i]);
    return std::max({(high - low) / (kContrast * tolerance), offset / (kMeanOffset * tolerance),
                     size / (kLargeLeaf * hierarchy_.extent_m())});
  }

  // Cuts the pieces that bend into four; the others are done. Where the limit does not let all be
  // cut, those go first that bend most over the largest area.
  std::vector<Candidate> Divide(const std::vector<Element>& pieces,
                                const std::vector<double>& bends,
                                std::vector<Element>* done) const {
    std::vector<size_t> chosen;
    std::vector<bool> cut(pieces.size(), false);
    for (size_t i = 0; i < pieces.size(); ++i) {
      if (bends[i] > 1 && pieces[i].id.level() + 2 <= kMaxLevel) chosen.push_back(i);
    }
    const uint64_t count = done->size() + pieces.size();
    const uint64_t room = count < options_.max_elements ? (options_.max_elements - count) / 3 : 0;
    if (chosen.size() > room) {
      const auto weight = [&](size_t i) {
        return bends[i] * hierarchy_.surface_area_m2(pieces[i].id.surface) *
               std::ldexp(1.0, -pieces[i].id.level());
      };
      std::stable_sort(chosen.begin(), chosen.end(),
                       [&](size_t a, size_t b) { return weight(a) > weight(b); });
      chosen.resize(room);
    }
    for (const size_t i : chosen) cut[i] = true;

    std::vector<Candidate> wave;
    wave.reserve(4 * chosen.size());
    for (size_t i = 0; i < pieces.size(); ++i) {
      const Element& piece = pieces[i];
      if (!cut[i]) {
        done->push_back(piece);
        continue;
      }
      const Field whole{ElementGeometry(hierarchy_.geometry(piece.id.surface), piece.id.path),
                        piece.irradiance};
      double mean = 0;
      for (int k = 0; k < whole.shape.count; ++k) {
        mean += Sum(piece.irradiance[k]) / whole.shape.count;
      }
      const auto tolerance =
          static_cast<float>(std::max<double>(Tolerance(mean), std::numeric_limits<float>::min()));
      const std::array<Field, 2> halves = Cut(whole);
      for (int h = 0; h < 2; ++h) {
        const std::array<Field, 2> quarters = Cut(halves[h]);
        for (int q = 0; q < 2; ++q) {
          wave.push_back({piece.id.Child(h).Child(q), piece.leaf, tolerance, quarters[q].value});
        }
      }
    }
    return wave;
  }

  const Hierarchy& hierarchy_;
  const std::vector<LeafRecord>& leaves_;
  const OutputMeshOptions& options_;
  const GatherFunction& gather_;
  Welder points_;                     // corners; a leaf is a group
  std::vector<Channels> irradiance_;  // of points_
  double mean_ = 0;
};

Channels Radiosity(const Optics& optics, const Channels& irradiance) {
  Channels result{};
  for (int c = 0; c < 3; ++c) {
    result[c] = static_cast<float>(optics.exitance[c] + optics.reflectance[c] * irradiance[c]);
  }
  return result;
}

// Elements → vertices and faces.
class Assembly {
 public:
  Assembly(const Hierarchy& hierarchy, const Snapshot& snapshot, std::vector<Element> elements)
      : hierarchy_(hierarchy),
        leaves_(snapshot.leaves),
        elements_(std::move(elements)),
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
    const std::vector<uint32_t> groups = FindWeldGroups(hierarchy_);
    corners_.assign(elements_.size(), {kNoCorner, kNoCorner, kNoCorner, kNoCorner});
    for (size_t e = 0; e < elements_.size(); ++e) {
      const Element& element = elements_[e];
      const uint32_t surface = element.id.surface;
      const ConvexPolygon shape = ElementGeometry(hierarchy_.geometry(surface), element.id.path);
      for (int k = 0; k < shape.count; ++k) {
        const uint32_t vertex = welder_.Vertex(shape.v[k], groups[surface]);
        corners_[e][k] = vertex;
        if (vertex == sums_.size()) sums_.push_back({{}, 0, surface, {}});
        for (int c = 0; c < 3; ++c) sums_[vertex].irradiance[c] += element.irradiance[k][c];
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
    }
  }

  void AddFaces(const std::vector<TVertex>& t_vertices, PatchFile* file) const {
    file->faces.reserve(elements_.size());
    size_t t = 0;
    for (size_t begin = 0; begin < elements_.size();) {
      size_t end = begin;
      while (end < elements_.size() && elements_[end].leaf == elements_[begin].leaf) ++end;
      const std::array<double, 3> scale = LeafScale({&elements_[begin], end - begin});
      for (; begin < end; ++begin) {
        PatchFace face;
        face.vertices = VertexList(begin, t_vertices, &t);
        if (face.vertices.size() < 3) continue;  // thinner than the tolerance
        FillFace(elements_[begin], scale, &face);
        file->faces.push_back(std::move(face));
      }
    }
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

  // By what the means of a leaf's parts are multiplied so that the leaf keeps its power.
  std::array<double, 3> LeafScale(std::span<const Element> parts) const {
    const LeafRecord& leaf = leaves_[parts.front().leaf];
    const int corners = hierarchy_.geometry(leaf.id.surface).count;
    std::array<double, 3> scale{1, 1, 1};
    for (int c = 0; c < 3; ++c) {
      double mean = 0, total = 0;
      for (const Element& part : parts) {
        // Relative to the leaf: parts of one level have nearly, but not always, the same area.
        const double area =
            ElementGeometry(hierarchy_.geometry(part.id.surface), part.id.path).Area();
        mean += area * MeanOfCorners(part, corners, c);
        total += area;
      }
      if (!(mean > 0)) continue;
      const double factor = leaf.irradiance[c] * total / mean;
      if (factor >= kLeastScale && factor <= kLargestScale) scale[c] = factor;
    }
    return scale;
  }

  void FillFace(const Element& element, const std::array<double, 3>& scale, PatchFace* face) const {
    const LeafRecord& leaf = leaves_[element.leaf];
    const uint32_t s = element.id.surface;
    const Surface& surface = hierarchy_.surfaces()[s];
    const int corners = hierarchy_.geometry(s).count;
    const Optics optics =
        hierarchy_.maps().Over(surface, ElementGeometry(hierarchy_.geometry(s), element.id.path));
    for (int c = 0; c < 3; ++c) {
      face->irradiance[c] =
          static_cast<float>(element.id == leaf.id ? leaf.irradiance[c]
                                                   : scale[c] * MeanOfCorners(element, corners, c));
      face->emission[c] = static_cast<float>(optics.exitance[c]);
    }
    face->radiosity = Radiosity(optics, face->irradiance);
    face->error = leaf.error;
    face->polygon = hierarchy_.scene().polygons[surface.polygon].file_polygon;
    face->surface = s;
    face->side = static_cast<uint8_t>(surface.side);
    face->path = element.id.path;
  }

  struct VertexSum {
    std::array<double, 3> irradiance{};
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
  const std::vector<LeafRecord>& leaves_;
  std::vector<Element> elements_;
  Welder welder_;
  std::vector<std::array<uint32_t, 4>> corners_;  // vertices of each element's corners
  std::vector<VertexSum> sums_;                   // of each vertex
};

}  // namespace

Result<PatchFile> BuildOutputMesh(const Hierarchy& hierarchy, const Snapshot& snapshot,
                                  const OutputMeshOptions& options, const GatherFunction& gather) {
  std::vector<uint32_t> all(snapshot.leaves.size());
  std::iota(all.begin(), all.end(), 0);
  ASSIGN_OR_RETURN(std::vector<Element> elements,
                   Refinement(hierarchy, snapshot, options, gather).Run(all));
  DivideByMaps(hierarchy, options.max_elements, &elements);
  return Assembly(hierarchy, snapshot, std::move(elements)).Run();
}

Result<std::vector<uint64_t>> CountOutputElements(const Hierarchy& hierarchy,
                                                  const Snapshot& snapshot,
                                                  const std::vector<uint32_t>& leaves,
                                                  const OutputMeshOptions& options,
                                                  const GatherFunction& gather) {
  ASSIGN_OR_RETURN(const std::vector<Element> elements,
                   Refinement(hierarchy, snapshot, options, gather).Run(leaves));
  std::vector<uint64_t> counts(leaves.size(), 0);
  for (const Element& element : elements) {
    const auto place = std::lower_bound(leaves.begin(), leaves.end(), element.leaf);
    ++counts[static_cast<size_t>(place - leaves.begin())];
  }
  return counts;
}

}  // namespace isolux
