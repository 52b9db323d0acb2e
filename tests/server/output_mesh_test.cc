#include "server/output_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "client/output/patch_locator.h"
#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "tests/support/scenes.h"

namespace isolux {
namespace {

using FieldFunction = std::function<Rgb(uint32_t surface, const Vec3& point)>;

double Value(double x) { return std::max(0.0, x); }

// Smooth, with a step on some surfaces.
Rgb Wavy(uint32_t surface, const Vec3& p) {
  const double base = 2 + std::sin(3 * p.x + surface) + std::cos(2 * p.y - p.z);
  const double step = surface % 2 == 0 && p.x + 0.7 * p.y + 0.3 * p.z > 0.9 ? 1.5 : 0.0;
  return {Value(base + step), Value(0.5 * base), Value(0.25 * base + 0.1 * step)};
}

// Corners by value of a field, as a gather gives them.
GatherFunction Gatherer(const Hierarchy& hierarchy, FieldFunction field) {
  return [&hierarchy, field](const std::vector<NodeId>& ids,
                             const std::vector<uint8_t>&) -> Result<std::vector<double>> {
    std::vector<double> values(12 * ids.size(), 0.0);
    EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
    for (size_t i = 0; i < ids.size(); ++i) {
      const ConvexPolygon shape = ElementGeometry(hierarchy.geometry(ids[i].surface), ids[i].path);
      for (int k = 0; k < shape.count; ++k) {
        const Rgb h = field(ids[i].surface, shape.v[k]);
        for (int c = 0; c < 3; ++c) values[12 * i + 3 * k + c] = h[c];
      }
    }
    return values;
  };
}

// Leaves at random levels up to `deepest`, with the field at their centroids.
Snapshot RandomLeaves(const Hierarchy& hierarchy, uint64_t seed, int deepest,
                      const FieldFunction& field) {
  Snapshot snapshot;
  Random random(seed);
  const std::function<void(NodeId)> add = [&](NodeId id) {
    if (id.level() < deepest && random.Unit() < 0.75) {
      add(id.Child(0));
      add(id.Child(1));
      return;
    }
    LeafRecord leaf;
    leaf.id = id;
    const Rgb h =
        field(id.surface, ElementGeometry(hierarchy.geometry(id.surface), id.path).Centroid());
    leaf.irradiance = {h.x, h.y, h.z};
    leaf.error = static_cast<float>(0.01 * h.x);
    snapshot.leaves.push_back(leaf);
  };
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) add({s, 1});
  return snapshot;
}

// A floor of quads and triangles of different sizes, side by side in one plane, and a lamp above.
Scene Patchwork() {
  Scene scene;
  scene.materials = {{"floor", Rgb(0.5), Rgb(0.0)}, {"lamp", Rgb(0.0), Rgb(1.0)}};
  const auto vertex = [&](double x, double y, double z) {
    scene.vertices.emplace_back(x, y, z);
    return static_cast<uint32_t>(scene.vertices.size() - 1);
  };
  const auto add = [&](std::vector<Vec3> corners, uint32_t material, uint8_t sides) {
    Polygon polygon;
    for (size_t k = 0; k < corners.size(); ++k) {
      polygon.vertices[k] = vertex(corners[k].x, corners[k].y, corners[k].z);
    }
    polygon.material = material;
    polygon.sides = sides;
    polygon.file_polygon = scene.file_polygon_count++;
    scene.polygons.push_back(polygon);
  };
  add({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, 0, kFrontTakesPart);
  add({{2, 0, 0}, {3, 0, 0}, {2, 0.7, 0}}, 0, kFrontTakesPart);
  add({{2, 0.7, 0}, {3, 0, 0}, {3, 2, 0}, {2, 2, 0}}, 0, kFrontTakesPart);
  // One wound the other way whose back shows up.
  add({{0, 2, 0}, {1.3, 3, 0}, {3, 2, 0}}, 0, kFrontTakesPart | kBackTakesPart);
  add({{0, 0, 2}, {0, 1, 2}, {1, 1, 2}, {1, 0, 2}}, 1, kFrontTakesPart | kFrontEmits);
  return scene;
}

double FaceArea(const PatchFile& file, const PatchFace& face) {
  Vec3 sum(0.0);
  const Vec3 origin = file.vertices[face.vertices[0]].position;
  for (size_t i = 1; i + 1 < face.vertices.size(); ++i) {
    sum += glm::cross(file.vertices[face.vertices[i]].position - origin,
                      file.vertices[face.vertices[i + 1]].position - origin);
  }
  return 0.5 * glm::length(sum);
}

// Connected faces, sharing vertices, have no vertex of theirs inside a side of another; and every
// side is shared by two faces or lies on the outline of what is connected.
void ExpectNoCracks(const PatchFile& file, double tolerance) {
  // Vertices of one plane and orientation are compared; positions tell the plane.
  std::map<std::pair<uint32_t, uint32_t>, int> directed;
  for (const PatchFace& face : file.faces) {
    ASSERT_GE(face.vertices.size(), 3U);
    const std::set<uint32_t> distinct(face.vertices.begin(), face.vertices.end());
    ASSERT_EQ(distinct.size(), face.vertices.size());
    for (size_t k = 0; k < face.vertices.size(); ++k) {
      ++directed[{face.vertices[k], face.vertices[(k + 1) % face.vertices.size()]}];
    }
  }
  std::vector<uint32_t> group(file.vertices.size());
  std::iota(group.begin(), group.end(), 0U);
  const std::function<uint32_t(uint32_t)> root = [&](uint32_t v) {
    while (group[v] != v) v = group[v] = group[group[v]];
    return v;
  };
  for (const auto& [edge, count] : directed) {
    EXPECT_EQ(count, 1);
    group[root(edge.first)] = root(edge.second);
  }
  for (const auto& [edge, count] : directed) {
    if (directed.count({edge.second, edge.first}) != 0) continue;
    const Vec3 a = file.vertices[edge.first].position, b = file.vertices[edge.second].position;
    for (uint32_t v = 0; v < file.vertices.size(); ++v) {
      if (root(v) != root(edge.first) || v == edge.first || v == edge.second) continue;
      const Vec3 p = file.vertices[v].position;
      const double t = glm::dot(p - a, b - a) / glm::dot(b - a, b - a);
      if (t <= 0 || t >= 1) continue;
      EXPECT_GT(glm::length(p - a - t * (b - a)), tolerance)
          << "vertex " << v << " lies on the side " << edge.first << " " << edge.second;
    }
  }
}

OutputMeshOptions Options(double accuracy, int waves) {
  OutputMeshOptions options;
  options.accuracy = accuracy;
  options.waves = waves;
  return options;
}

PatchFile Build(const Hierarchy& hierarchy, const Snapshot& snapshot,
                const OutputMeshOptions& options, const FieldFunction& field) {
  auto file = BuildOutputMesh(hierarchy, snapshot, options, Gatherer(hierarchy, field));
  EXPECT_TRUE(file.has_value()) << file.error().message();
  return file.has_value() ? std::move(file->patch) : PatchFile{};
}

TEST(OutputMesh, HasNoCracks) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const Scene scene = seed % 2 == 0 ? Patchwork() : testing::RandomRoom(seed, 2);
    const Hierarchy hierarchy(scene);
    const Snapshot snapshot = RandomLeaves(hierarchy, seed, 5, Wavy);
    const PatchFile file = Build(hierarchy, snapshot, Options(0.1, 3), Wavy);
    EXPECT_GT(file.faces.size(), snapshot.leaves.size());
    ExpectNoCracks(file, 1e-6 * hierarchy.extent_m());
  }
}

TEST(OutputMesh, CoplanarNeighboursShareVerticesAlsoAcrossPolygonsAndSides) {
  const Scene scene = Patchwork();
  const Hierarchy hierarchy(scene);
  const Snapshot snapshot = RandomLeaves(hierarchy, 1, 0, Wavy);
  const PatchFile file = Build(hierarchy, snapshot, Options(0.1, 1), Wavy);
  // 8 corners over the four polygons seen from above; the last one from below, and the lamp, apart.
  EXPECT_EQ(file.vertices.size(), 8U + 3U + 4U);
  ASSERT_EQ(file.faces.size(), 6U);
  EXPECT_EQ(file.faces[0].vertices.size(), 5U);  // (2, 0.7) on its side
  EXPECT_EQ(file.faces[4].side, 1U);
  EXPECT_EQ(file.faces[4].vertices.size(), 4U);  // seen from above: (2, 2) on its side
  EXPECT_EQ(file.faces[3].vertices.size(), 3U);  // from below: nothing beside it
  ExpectNoCracks(file, 1e-6 * hierarchy.extent_m());
}

TEST(OutputMesh, KeepsTheEnergyOfEachLeaf) {
  const Scene scene = testing::CornellBox(true);
  const Hierarchy hierarchy(scene);
  const Snapshot snapshot = RandomLeaves(hierarchy, 3, 6, Wavy);
  const PatchFile file = Build(hierarchy, snapshot, Options(0.02, 4), Wavy);
  const double metres = scene.metres_per_unit;
  size_t next = 0;
  for (const LeafRecord& leaf : snapshot.leaves) {
    std::array<double, 3> power{};
    double area = 0;
    for (; next < file.faces.size(); ++next) {
      const PatchFace& face = file.faces[next];
      if (!Contains(leaf.id, {face.surface, face.path})) break;
      const double part = FaceArea(file, face) * metres * metres;
      for (int c = 0; c < 3; ++c) power[c] += part * face.irradiance[c];
      area += part;
    }
    const double expected_area =
        ElementGeometry(hierarchy.geometry(leaf.id.surface), leaf.id.path).Area();
    EXPECT_NEAR(area, expected_area, 1e-5 * expected_area);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(power[c], area * leaf.irradiance[c], 1e-5 * power[c] + 1e-12);
    }
  }
  EXPECT_EQ(next, file.faces.size());
}

TEST(OutputMesh, DividesWhereTheIrradianceBendsOnly) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  const FieldFunction step = [](uint32_t surface, const Vec3& p) {
    return Rgb(surface == 0 && p.y > 0.4 ? 2.0 : 1.0);
  };
  Snapshot snapshot;
  for (uint32_t s = 0; s < 6; ++s) {
    for (uint64_t path = 64; path < 128; ++path) snapshot.leaves.push_back({{s, path}, {1, 1, 1}});
  }
  for (LeafRecord& leaf : snapshot.leaves) {
    const Rgb h =
        step(leaf.id.surface,
             ElementGeometry(hierarchy.geometry(leaf.id.surface), leaf.id.path).Centroid());
    leaf.irradiance = {h.x, h.y, h.z};
  }
  const PatchFile file = Build(hierarchy, snapshot, Options(0.02, 4), step);
  for (const PatchFace& face : file.faces) {
    const int level = NodeId{face.surface, face.path}.level();
    if (face.surface != 0) {
      EXPECT_EQ(level, 6);
      continue;
    }
    double low = 1, high = 0;
    for (const uint32_t v : face.vertices) {
      low = std::min(low, file.vertices[v].position.y);
      high = std::max(high, file.vertices[v].position.y);
    }
    // The step is found to 1/8 of a leaf; far from it the leaves stay whole.
    if (low <= 0.4 && high > 0.4) {
      EXPECT_EQ(level, 12);
    }
    if (high < 0.25 || low > 0.55) {
      EXPECT_EQ(level, 6);
    }
  }
}

TEST(OutputMesh, BelievesWhatWasGatheredWhereLinksAreInDoubt) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  Snapshot snapshot;
  for (uint32_t s = 0; s < 6; ++s) {
    LeafRecord leaf{{s, 1}, {3, 3, 3}};
    leaf.doubt = s == 0 ? 0.0F : s == 1 ? 3.0F : 300.0F;
    snapshot.leaves.push_back(leaf);
  }
  const PatchFile file =
      Build(hierarchy, snapshot, Options(0.1, 1), [](uint32_t, const Vec3&) { return Rgb(2.0); });
  ASSERT_EQ(file.faces.size(), 6U);
  EXPECT_FLOAT_EQ(file.faces[0].irradiance[0], 3);
  EXPECT_FLOAT_EQ(file.faces[1].irradiance[0], 2.5);  // 3 W/m² in doubt to 6 gathered: even
  EXPECT_NEAR(file.faces[2].irradiance[0], 2, 1e-3);
}

// A bright strip much narrower than what the first waves resolve.
TEST(OutputMesh, DividesOnWhereInterpolationLosesMuch) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  const auto strip = [](uint32_t surface, const Vec3& p) {
    return Rgb(surface == 0 && p.y > 0.4 && p.y < 0.53 ? 40.0 : 1.0);
  };
  Snapshot snapshot;
  for (uint32_t s = 0; s < 6; ++s) snapshot.leaves.push_back({{s, 1}, {1, 1, 1}});
  snapshot.leaves[0].irradiance = {6.07, 6.07, 6.07};
  for (LeafRecord& leaf : snapshot.leaves) leaf.doubt = 1e6F;
  double last = INFINITY;
  for (const int further : {0, 2, 5}) {
    OutputMeshOptions options = Options(0.02, 4);
    options.further_waves = further;
    const auto mesh = BuildOutputMesh(hierarchy, snapshot, options, Gatherer(hierarchy, strip));
    ASSERT_TRUE(mesh.has_value());
    // The true error: of 8 × 8 points a face, against the field.
    double off = 0, arriving = 0;
    for (const PatchFace& face : mesh->patch.faces) {
      const double area = FaceArea(mesh->patch, face);
      Vec3 low(INFINITY), high(-INFINITY);
      for (const uint32_t v : face.vertices) {
        low = glm::min(low, mesh->patch.vertices[v].position);
        high = glm::max(high, mesh->patch.vertices[v].position);
      }
      for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 8; ++k) {
          const Vec3 at((i + 0.5) / 8, (k + 0.5) / 8, face.surface < 4 ? (i + 0.5) / 8 : 0.5);
          const Vec3 p = low + at * (high - low);
          const double value = strip(face.surface, p).x;
          const uint32_t f = static_cast<uint32_t>(&face - mesh->patch.faces.data());
          off += area * std::abs(IrradianceAt(mesh->patch, f, p).x - value);
          arriving += area * value;
        }
      }
    }
    const double error = off / arriving;
    EXPECT_LT(error, 2 * mesh->interpolation_error) << further << " further waves";
    EXPECT_GT(error, 0.3 * mesh->interpolation_error) << further << " further waves";
    EXPECT_LT(mesh->interpolation_error, 0.5 * last);
    last = mesh->interpolation_error;
  }
}

TEST(OutputMesh, KeepsToItsLimit) {
  const Scene scene = testing::CornellBox(false);
  const Hierarchy hierarchy(scene);
  const Snapshot snapshot = RandomLeaves(hierarchy, 5, 6, Wavy);
  OutputMeshOptions options = Options(0.001, 4);
  options.max_elements = snapshot.leaves.size() + 100;
  const PatchFile file = Build(hierarchy, snapshot, options, Wavy);
  EXPECT_LE(file.faces.size(), options.max_elements);
  EXPECT_GT(file.faces.size(), snapshot.leaves.size() + 90);
}

TEST(OutputMesh, LeavesDarkSurfacesOut) {
  const Scene scene = testing::FurnaceCube(0.5, 0.0);
  const Hierarchy hierarchy(scene);
  const FieldFunction field = [](uint32_t surface, const Vec3& p) {
    return Rgb(surface == 2 ? (p.x > 0.5 ? 1.0 : 0.0) : surface == 3 ? 1.0 : 0.0);
  };
  const Snapshot snapshot = RandomLeaves(hierarchy, 2, 4, field);
  const PatchFile file = Build(hierarchy, snapshot, Options(0.1, 3), field);
  std::map<uint32_t, double> area;
  for (const PatchFace& face : file.faces) area[face.surface] += FaceArea(file, face);
  ASSERT_EQ(area.size(), 2U);
  EXPECT_NEAR(area[2], 1.0, 1e-6);  // dark parts of a lit surface stay
  EXPECT_NEAR(area[3], 1.0, 1e-6);
}

TEST(OutputMesh, TheOrderAndGroupingOfTheGatherDoNotMatter) {
  const Scene scene = testing::RandomRoom(11, 3);
  const Hierarchy hierarchy(scene);
  const Snapshot snapshot = RandomLeaves(hierarchy, 11, 5, Wavy);
  const GatherFunction plain = Gatherer(hierarchy, Wavy);
  // One element at a time, last to first.
  const GatherFunction shuffled = [&](const std::vector<NodeId>& ids,
                                      const std::vector<uint8_t>&) -> Result<std::vector<double>> {
    std::vector<double> values(12 * ids.size());
    for (size_t i = ids.size(); i-- > 0;) {
      ASSIGN_OR_RETURN(const std::vector<double> one, plain({ids[i]}, {15}));
      std::copy(one.begin(), one.end(), values.begin() + static_cast<std::ptrdiff_t>(12 * i));
    }
    return values;
  };
  const auto a = BuildOutputMesh(hierarchy, snapshot, Options(0.05, 4), plain);
  const auto b = BuildOutputMesh(hierarchy, snapshot, Options(0.05, 4), shuffled);
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(Encode(a->patch), Encode(b->patch));
}

TEST(OutputMesh, CoordinatesAreTheFilesAndTheRestIsPhysics) {
  Scene scene = testing::BoxRoom(Vec3(1, 2, 3), {{}, {Rgb(1.0, 2.0, 3.0)}});
  for (Material& material : scene.materials) material.reflectance = Rgb(0.25, 0.5, 0.75);
  scene.origin_m = Vec3(10, 20, 30);
  scene.metres_per_unit = 0.01;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) scene.polygons[p].file_polygon = 100 + p;
  const Hierarchy hierarchy(scene);
  const FieldFunction field = [](uint32_t, const Vec3&) { return Rgb(4.0, 5.0, 6.0); };
  const Snapshot snapshot = RandomLeaves(hierarchy, 4, 0, field);
  const PatchFile file = Build(hierarchy, snapshot, Options(0.1, 1), field);
  ASSERT_EQ(file.faces.size(), 6U);
  Bounds3 bounds;
  for (const PatchVertex& v : file.vertices) bounds.Add(v.position);
  EXPECT_NEAR(glm::length(bounds.low - Vec3(1000, 2000, 3000)), 0, 1e-9);
  EXPECT_NEAR(glm::length(bounds.high - Vec3(1100, 2200, 3300)), 0, 1e-9);
  for (const PatchFace& face : file.faces) {
    EXPECT_EQ(face.polygon, 100 + face.surface);
    EXPECT_EQ(face.irradiance, (std::array<float, 3>{4, 5, 6}));
    const Surface& surface = hierarchy.surfaces()[face.surface];
    for (int c = 0; c < 3; ++c) {
      EXPECT_FLOAT_EQ(face.emission[c], static_cast<float>(surface.exitance[c]));
      EXPECT_FLOAT_EQ(face.radiosity[c],
                      static_cast<float>(surface.exitance[c]) +
                          static_cast<float>(surface.reflectance[c]) * face.irradiance[c]);
    }
    EXPECT_FLOAT_EQ(face.error, 0.04F);
  }
}

TEST(OutputMesh, BadGathersGiveNoNonsense) {
  const Scene scene = testing::FurnaceCube(0.5, 1.0);
  const Hierarchy hierarchy(scene);
  const FieldFunction field = [](uint32_t surface, const Vec3&) {
    return surface == 1 ? Rgb(NAN, INFINITY, -1.0) : Rgb(1.0);
  };
  const FieldFunction ones = [](uint32_t, const Vec3&) { return Rgb(1.0); };
  const Snapshot snapshot = RandomLeaves(hierarchy, 4, 3, ones);
  const PatchFile file = Build(hierarchy, snapshot, Options(0.1, 4), field);
  for (const PatchVertex& v : file.vertices) {
    for (const float h : v.irradiance) EXPECT_TRUE(std::isfinite(h) && h >= 0);
  }
  const auto failed = BuildOutputMesh(
      hierarchy, snapshot, Options(0.1, 4),
      [](const std::vector<NodeId>&, const std::vector<uint8_t>&) -> Result<std::vector<double>> {
        return Error(StatusCode::kUnavailable, "worker lost");
      });
  ASSERT_FALSE(failed.has_value());
  EXPECT_EQ(failed.error().code(), StatusCode::kUnavailable);
  EXPECT_FALSE(BuildOutputMesh(hierarchy, snapshot, Options(0.1, 4),
                               [](const std::vector<NodeId>&, const std::vector<uint8_t>&) {
                                 return Result<std::vector<double>>(std::vector<double>(5));
                               })
                   .has_value());
}

}  // namespace
}  // namespace isolux
