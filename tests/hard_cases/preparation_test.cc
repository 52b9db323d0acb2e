// Hard cases of the road from a file to what transport sees: things that stand on, sink into and
// hang over each other by next to nothing, degenerate and doubled input, units and places.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

#include "client/output/comparison.h"
#include "client/output/patch_locator.h"
#include "common/hierarchy/hierarchy.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/support/local_cluster.h"
#include "tests/support/obj_scene.h"
#include "tests/support/polygons.h"
#include "worker/radiosity/polygon_sampler.h"
#include "worker/radiosity/ray_scene.h"

namespace isolux::testing {
namespace {

PatchFile SolveScene(const Scene& scene, double accuracy) {
  SolveOptions options;
  options.accuracy = accuracy;
  options.max_rounds = 8;
  Result<SolveResult> result = SolveInProcess(scene, options, 1, 1);
  EXPECT_TRUE(result.has_value()) << result.error().message();
  return result.has_value() ? std::move(result->patch) : PatchFile();
}

// The largest irradiance of faces whose middle `takes`, over the largest of all.
template <typename Takes>
double BrightestShare(const PatchFile& patch, const Takes& takes) {
  double most = 0, within = 0;
  for (const PatchFace& face : patch.faces) {
    Vec3 middle(0.0);
    for (const uint32_t v : face.vertices)
      middle += patch.vertices[v].position / static_cast<double>(face.vertices.size());
    for (const float h : face.irradiance) {
      most = std::max(most, static_cast<double>(h));
      if (takes(middle)) within = std::max(within, static_cast<double>(h));
    }
  }
  return most > 0 ? within / most : std::numeric_limits<double>::infinity();
}

// A closed room of two halves with a wall across, a lamp on one side.
ObjScene DividedRoom(double gap) {
  ObjScene scene;
  scene.Box("white", {0, 0, 0}, {4, 3, 2}, true, true, true);
  scene.Level("lamp", 0.5, 1, 1.5, 2, 1.9, false);
  scene.Face("red", {{2, 0, gap}, {2, 3, gap}, {2, 3, 2}, {2, 0, 2}});
  return scene;
}

TEST(HardPreparation, WallStandingOnAFloor) {
  HardCase hard("14", "wall standing on a floor with gap 0, 1e-9 and sunk by 1e-9",
                "light behind the wall over that before it", 1e-6);
  for (const double gap : {0.0, 1e-9, -1e-9}) {
    const PatchFile patch = SolveScene(DividedRoom(gap).Import(), 0.1);
    hard.Measure(BrightestShare(patch, [](const Vec3& p) { return p.x > 2 + 1e-6; }),
                 fmt::format("gap {}", gap));
  }
}

bool UnderALeg(const Vec3& p) {
  const auto within = [](double x, double low) { return x > low + 1e-6 && x < low + 0.2 - 1e-6; };
  return (within(p.x, 0.5) || within(p.x, 2.2)) && (within(p.y, 0.6) || within(p.y, 2.1)) &&
         std::abs(p.z) < 0.005;
}

// Rays, of `count`, that pass from the floor under a leg to polygons around, but for those of the
// floor itself.
int LeakingRays(const Scene& scene, int count, uint64_t seed) {
  const Hierarchy hierarchy(scene);
  const RayScene rays(hierarchy);
  Random random(Mix(seed));
  std::vector<uint32_t> under, around;
  for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
    const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
    const Vec3 centre = shape.Centroid() + scene.origin_m;
    const bool white = scene.materials[scene.polygons[p].material].name == "white";
    if (white && UnderALeg(centre)) under.push_back(p);
    if (white && centre.z > 0.1) around.push_back(p);
  }
  EXPECT_EQ(under.size(), 4U);
  int passed = 0;
  for (int i = 0; i < count; ++i) {
    const auto point = [&](uint32_t polygon) {
      const ConvexPolygon shape =
          DrawnIn(SideGeometry(scene, polygon, Side::kFront), rays.coordinate_noise_m());
      const double u = random.Unit();
      return SamplePolygon(shape, u, random.Unit());
    };
    const uint32_t from = under[random.Bits() % under.size()];
    const uint32_t to = around[random.Bits() % around.size()];
    const Vec3 start = point(from);
    passed += rays.Visible(Segment{start, point(to), from, to}) ? 1 : 0;
  }
  return passed;
}

TEST(HardPreparation, LegsOnAFloor) {
  HardCase hard("46", "furniture legs standing on, sunk into and floating 1e-9 above a floor",
                "rays of 20,000 that get out from under a leg", 0);
  HardCase rows("46a", "the same: area of the floor in and around the legs",
                "share of the floor's area that is not accounted for", 1e-12);
  HardCase light("46b", "the same, solved to 10 and 2 %",
                 "light under a leg over the most anywhere", 0);
  for (const double z : {0.0, -1e-9, 1e-9, -0.01}) {
    for (const bool bottom : {true, false}) {
      const std::string where = fmt::format("legs at {}, bottoms {}", z, bottom);
      ObjScene room;
      room.Box("white", {0, 0, 0}, {3, 3, 2}, true, true, true);
      room.Level("lamp", 1, 1, 2, 2, 1.95, false);
      for (const double x : {0.5, 2.2}) {
        for (const double y : {0.6, 2.1})
          room.Box("red", {x, y, z}, {x + 0.2, y + 0.2, 0.7}, bottom);
      }
      const Scene scene = room.Import();
      double floor = 0;
      for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
        const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
        const Vec3 c = shape.Centroid() + scene.origin_m;
        if (scene.materials[scene.polygons[p].material].name == "white" && std::abs(c.z) < 1e-6)
          floor += shape.Area();
      }
      rows.Measure(std::abs(floor / 9 - 1), where);
      hard.Measure(LeakingRays(scene, 20'000, 1), where);
      for (const double accuracy : {0.1, 0.02}) {
        if (accuracy < 0.1 && !(z == -1e-9 && !bottom)) continue;
        light.Measure(BrightestShare(SolveScene(scene, accuracy), UnderALeg), where);
      }
    }
  }
}

TEST(HardPreparation, AreaIsKept) {
  HardCase hard("47", "200 random heaps of boxes, standing on, in and through each other",
                "change of the area of a material by cutting", 1e-12);
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(Mix(seed));
    const auto unit = [&] { return random.Unit(); };
    ObjScene heap;
    heap.Box("white", {0, 0, 0}, {4, 4, 3}, true, true, true);
    double expected = 0;
    for (uint64_t n = 1 + random.Bits() % 6; n > 0; --n) {
      const Vec3 low(3 * unit(), 3 * unit(), unit() < 0.5 ? 0 : 2 * unit() - 0.3);
      const Vec3 size(0.2 + 0.8 * unit(), 0.2 + 0.8 * unit(), 0.2 + unit());
      heap.Box("red", low, low + size);
      expected += 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
    }
    const Scene scene = heap.Import();
    const auto area = AreaByMaterial(scene);
    const std::string where = fmt::format("seed {}", seed);
    hard.Measure(std::abs(area.at("white") / 80 - 1), where);
    hard.Measure(std::abs(area.at("red") / expected - 1), where);
    for (uint32_t p = 0; p < scene.polygons.size(); ++p) {
      const ConvexPolygon shape = SideGeometry(scene, p, Side::kFront);
      ASSERT_TRUE(HasArea(shape) && IsPlanar(shape) && IsConvex(shape)) << where;
    }
  }
}

// Area that takes part, by material, m².
std::map<std::string, double> SeenArea(const Scene& scene) {
  std::map<std::string, double> area;
  for (const Surface& surface : MakeSurfaces(scene)) {
    area[scene.materials[scene.polygons[surface.polygon].material].name] +=
        SideGeometry(scene, surface.polygon, surface.side).Area();
  }
  return area;
}

double LargestChange(const std::map<std::string, double>& a,
                     const std::map<std::string, double>& b) {
  double most = a.size() == b.size() ? 0 : std::numeric_limits<double>::infinity();
  for (const auto& [name, area] : a) {
    const auto at = b.find(name);
    if (at == b.end()) return std::numeric_limits<double>::infinity();
    most = std::max(most, std::abs(at->second / area - 1));
  }
  return most;
}

ObjScene Furnished() {
  ObjScene room;
  room.Box("white", {0, 0, 0}, {4, 4, 3}, true, true, true);
  room.Box("red", {1, 1, 0}, {2, 2.2, 0.8});
  room.Box("blue", {1.2, 1.2, 0.8}, {1.9, 2, 1.5});
  room.Level("red", 2.4, 0.5, 3.5, 3, 0);
  room.Level("lamp", 1.5, 1.5, 2.5, 2.5, 3, false);
  return room;
}

TEST(HardPreparation, DoubledShuffledAndDividedAnew) {
  HardCase hard("20", "duplicates, coplanar overlap, T-junctions, other order, other triangles",
                "change of the area that takes part, by material", 1e-9);
  const auto expected = SeenArea(Furnished().Import());
  ObjScene doubled = Furnished();
  for (const ObjFaceText& face : Furnished().faces) doubled.faces.push_back(face);
  hard.Measure(LargestChange(expected, SeenArea(doubled.Import())), "doubled");
  ObjScene flipped = Furnished();
  for (const ObjFaceText& face : Furnished().faces) {
    flipped.faces.push_back(face);
    auto& corners = flipped.faces.back().corners;
    std::reverse(corners.begin(), corners.end());
  }
  hard.Measure(std::abs(AreaByMaterial(flipped.Import())["white"] / 80 - 1), "with reversed twins");
  ObjScene triangles, other_triangles, both;
  for (const ObjFaceText& face : Furnished().faces) {
    const auto& c = face.corners;
    triangles.Face(face.material, {c[0], c[1], c[2]});
    triangles.Face(face.material, {c[2], c[3], c[0]});
    other_triangles.Face(face.material, {c[1], c[2], c[3]});
    other_triangles.Face(face.material, {c[3], c[0], c[1]});
  }
  hard.Measure(LargestChange(expected, SeenArea(triangles.Import())), "triangles");
  hard.Measure(LargestChange(expected, SeenArea(other_triangles.Import())), "other triangles");
  both.faces = triangles.faces;
  both.faces.insert(both.faces.end(), other_triangles.faces.begin(), other_triangles.faces.end());
  hard.Measure(LargestChange(expected, SeenArea(both.Import())), "both");
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(Mix(seed));
    ObjScene shuffled = triangles;
    for (size_t i = shuffled.faces.size(); i > 1; --i)
      std::swap(shuffled.faces[i - 1], shuffled.faces[random.Bits() % i]);
    hard.Measure(LargestChange(expected, SeenArea(shuffled.Import())),
                 fmt::format("shuffled, seed {}", seed));
  }
}

// A solution at points even over its faces.
std::vector<ReferencePoint> PointsOf(const PatchFile& patch) {
  std::vector<ReferencePoint> points;
  constexpr double kArea = 0.01;  // of a point, m²
  Random random(20);
  for (uint32_t f = 0; f < patch.faces.size(); ++f) {
    const std::vector<Vec3> corners = CornersOf(patch, patch.faces[f]);
    const Vec3 area = AreaVector(corners);
    const double count = glm::length(area) / kArea + random.Unit();
    for (int k = 1; k <= count; ++k) {
      const Vec3 at = PointOn(corners, random);
      points.push_back({at, glm::normalize(area), IrradianceAt(patch, f, at)});
    }
  }
  return points;
}

// What light does in them is the same too.
TEST(HardPreparation, DoubledAndDividedAnewSolved) {
  HardCase same("20a", "duplicates, coplanar overlap, T-junctions, other triangles, whole solves",
                "difference over the sum of the estimates", 1);
  HardCase conserved("20b", "the same", "energy imbalance over the error estimate", 1);
  HardCase bounded("20c", "the same", "largest B over E / (1 - largest rho)", 1);
  const auto solve = [&](const ObjScene& room, const std::string& where) {
    SolveOptions options;
    options.accuracy = 0.05;
    Result<SolveResult> result = SolveInProcess(room.Import(), options, 1, 2);
    EXPECT_TRUE(result.has_value());
    const RoundSummary& last = result->summary.rounds.back();
    conserved.Measure(last.energy_imbalance / last.error_estimate, where);
    for (const PatchVertex& vertex : result->patch.vertices)
      bounded.Measure(vertex.radiosity[0] * (1 - 0.7) / 10, where);
    return *std::move(result);
  };
  const SolveResult plain = solve(Furnished(), "plain");
  const std::vector<ReferencePoint> points = PointsOf(plain.patch);
  const auto compare = [&](const ObjScene& room, const std::string& where) {
    const SolveResult other = solve(room, where);
    const double difference = Compare(other.patch, points).value().l1_relative;
    same.Measure(difference / (plain.summary.rounds.back().error_estimate +
                               other.summary.rounds.back().error_estimate),
                 where);
  };
  ObjScene doubled = Furnished(), triangles, both, tiled;
  for (const ObjFaceText& face : Furnished().faces) {
    const auto& c = face.corners;
    doubled.faces.push_back(face);
    triangles.Face(face.material, {c[0], c[1], c[2]});
    triangles.Face(face.material, {c[2], c[3], c[0]});
    for (const int k : {0, 1, 2, 3})
      both.Face(face.material, {c[k], c[(k + 1) % 4], c[(k + 2) % 4]});
    // Three strips, of which the middle one is cut across: T-junctions.
    const auto at = [&](double u, double v) {
      return (1 - v) * ((1 - u) * c[0] + u * c[1]) + v * ((1 - u) * c[3] + u * c[2]);
    };
    for (const auto& [u0, u1, v0, v1] :
         {std::array{0.0, 1.0, 0.0, 0.3}, std::array{0.0, 0.45, 0.3, 0.8},
          std::array{0.45, 1.0, 0.3, 0.8}, std::array{0.0, 1.0, 0.8, 1.0}}) {
      tiled.Face(face.material, {at(u0, v0), at(u1, v0), at(u1, v1), at(u0, v1)});
    }
  }
  compare(doubled, "doubled");
  compare(triangles, "triangles");
  compare(both, "both triangulations");
  compare(tiled, "T-junctions");
}

TEST(HardPreparation, UnitsAndPlaces) {
  HardCase hard("4", "the same room in millimetres, in kilometres, and 10^6 sizes from the origin",
                "change of the area that takes part, by material and place", 1e-7);
  const auto expected = SeenArea(Furnished().Import());
  const auto measure = [&](const Scene& scene, double scale, const char* where) {
    auto area = SeenArea(scene);
    for (auto& [name, a] : area) a /= scale * scale;
    hard.Measure(LargestChange(expected, area), where);
  };
  ImportOptions mm;
  mm.unit = "mm";
  measure(Furnished().Import(mm, 17, Vec3(0.0), 1000), 1, "mm");
  measure(Furnished().Import({}, 17, Vec3(0.0), 1000), 1000, "km");
  measure(Furnished().Import({}, 17, Vec3(4e6, -4e6, 4e6)), 1, "moved by 10^6 sizes");
  measure(Furnished().Import({}, 6), 1, "six digits");
}

TEST(HardPreparation, DegenerateInput) {
  HardCase hard("21", "zero area, two corners, collinear, bent, crossing itself, nan, infinite",
                "inputs that are neither mended with a count nor refused with a line", 0);
  std::map<std::string, uint64_t> without;  // what the room is mended by before
  for (const auto& entry : Furnished().Import().repairs.entries) without[entry.kind] = entry.count;
  const auto bad = [&](const std::vector<Vec3>& corners, const char* where) {
    ObjScene scene = Furnished();
    scene.Face("red", corners);
    const Result<Scene> result = scene.TryImport();
    bool good = false;
    if (result.has_value()) {
      for (const auto& entry : result->repairs.entries) {
        const bool more = entry.count > without[entry.kind];
        good |= more && entry.example.find("s.obj:") != std::string::npos;
      }
      good = good && Validate(*result).ok();
    } else {
      good = result.error().message().find("s.obj:") != std::string::npos;
    }
    hard.Measure(good ? 0 : 1, where);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  bad({{1, 1, 2}, {1, 1, 2}, {1, 1, 2}}, "one point");
  bad({{1, 1, 2}, {2, 1, 2}}, "two corners");
  bad({{1, 1, 2}, {2, 1, 2}, {3, 1, 2}}, "collinear");
  bad({{1, 1, 2}, {2, 1, 2}, {2, 2, 2.3}, {1, 2, 2}}, "bent");
  bad({{1, 1, 2}, {2, 2, 2}, {2, 1, 2}, {1, 2, 2}}, "crossing itself");
  bad({{1, 1, 2}, {2, 1, nan}, {2, 2, 2}}, "nan");
  bad({{1, 1, 2}, {2, 1, inf}, {2, 2, 2}}, "infinite");
}

TEST(HardPreparation, TessellatedWall) {
  HardCase hard("41",
                "a wall in 100,352 triangles, one plane; the same with every other one of "
                "another material",
                "planes more than one, and polygons more than one where they are alike", 0);
  for (const bool mixed : {false, true}) {
    ObjScene text;
    const int n = 224;
    for (int i = 0; i < n * n; ++i) {
      const auto at = [&](int x, int y) {
        return Vec3(0.01 * (i % n + x), 0.013 * (i / n + y), 1.0 / 3 + 0.01 * (i % n + x));
      };
      text.Face("red", {at(0, 0), at(1, 0), at(1, 1)});
      text.Face(mixed ? "blue" : "red", {at(1, 1), at(0, 1), at(0, 0)});
    }
    const Scene scene = text.Import({}, 9);
    const Hierarchy hierarchy(scene);
    uint32_t planes = 0;
    for (uint32_t p = 0; p < scene.polygons.size(); ++p)
      planes = std::max(planes, hierarchy.plane_of(p) + 1);
    hard.Measure(planes - 1, mixed ? "planes, two materials" : "planes, one material");
    if (!mixed) hard.Measure(static_cast<double>(scene.polygons.size()) - 1, "polygons");
  }
}

}  // namespace
}  // namespace isolux::testing
