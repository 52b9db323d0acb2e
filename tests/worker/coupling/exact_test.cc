// Couplings that are known exactly: closed forms, symmetry, and values computed to eighteen digits;
// in both orders, turned and scaled. More of them are taken from a collection of exact cases where
// one is at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/exact_factors.h"
#include "tests/support/polygons.h"
#include "tests/support/shapes.h"
#include "tests/support/shared_folder.h"
#include "tests/worker/coupling/random_pairs.h"
#include "tests/worker/coupling/reference.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

using testing::OpposedRectangles;
using testing::RightAngle;

constexpr double kPi = std::numbers::pi;

struct ExactCase {
  std::string name;
  ConvexPolygon p, q;
  double coupling_m2;
  double tolerance = 1e-8;  // of the smaller area
};

ConvexPolygon Quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return {4, {a, b, c, d}};
}
ConvexPolygon Triangle(const Vec3& a, const Vec3& b, const Vec3& c) { return {3, {a, b, c}}; }

// [0, a] × [0, b] at height z, seen from above or from below.
ConvexPolygon Floor(double a, double b, double z = 0) {
  return Quad({0, 0, z}, {a, 0, z}, {a, b, z}, {0, b, z});
}
ConvexPolygon Ceiling(double a, double b, double z) { return testing::Reversed(Floor(a, b, z)); }
// Stands on the side y = 0 of the floor, length × height, and faces it.
ConvexPolygon Wall(double length, double height) {
  return Quad({0, 0, 0}, {0, 0, height}, {length, 0, height}, {length, 0, 0});
}

ExactCase Dihedral(double degrees, double exact) {
  const double angle = degrees * kPi / 180;
  const double y = std::cos(angle), z = std::sin(angle);
  return {"dihedral angle of " + std::to_string(degrees), Floor(1, 1),
          Quad({0, 0, 0}, {0, y, z}, {1, y, z}, {1, 0, 0}), exact};
}

std::vector<ExactCase> ExactCases() {
  std::vector<ExactCase> cases;
  for (const double c : {1e-4, 0.01, 0.3, 1.0, 3.0, 10.0}) {
    cases.push_back({"opposed squares at " + std::to_string(c), Floor(1, 1), Ceiling(1, 1, c),
                     OpposedRectangles(1, 1, c)});
  }
  cases.push_back(
      {"opposed squares far apart", Floor(1, 1), Ceiling(1, 1, 1e4), 3.18309884061724782e-9});
  cases.push_back(
      {"long strips", Floor(1, 1000), Ceiling(1, 1000, 1), OpposedRectangles(1, 1000, 1)});
  cases.push_back({"unequal rectangles off each other", Floor(1, 1),
                   Quad({0.3, -0.4, 0.7}, {0.3, 0.5, 0.7}, {2.1, 0.5, 0.7}, {2.1, -0.4, 0.7}),
                   testing::ParallelRectangles({0, 1}, {0, 1}, {0.3, 2.1}, {-0.4, 0.5}, 0.7)});
  cases.push_back({"squares at a right angle", Floor(1, 1), Wall(1, 1), RightAngle(1, 1, 1)});
  cases.push_back({"a wall on a floor", Floor(1, 2), Wall(1, 0.5), RightAngle(1, 0.5, 2)});
  cases.push_back({"squares at a right angle, 1e-6 apart",
                   Quad({0, 1e-6, 0}, {1, 1e-6, 0}, {1, 1 + 1e-6, 0}, {0, 1 + 1e-6, 0}), Wall(1, 1),
                   testing::PerpendicularRectangles({1e-6, 1 + 1e-6}, {0, 1}, {0, 1}, {0, 1})});
  // A sliver along the foot of a wall: C is that of the sliver as the floor.
  cases.push_back(
      {"a sliver at a wall", Floor(1, 1e-4), Wall(1, 1), 0.0000499822555528782134, 0.4998e-6});
  cases.push_back(Dihedral(30, 0.619028323090803253));
  cases.push_back(Dihedral(60, 0.370905321150051436));
  cases.push_back(Dihedral(150, 0.0213453254126893704));
  // Each face of a regular tetrahedron sees the three others alike.
  const Vec3 a(-1, 1, -1), b(1, -1, -1), c(1, 1, 1), d(-1, -1, 1);
  cases.push_back({"faces of a tetrahedron", Triangle(a, b, c), Triangle(c, b, d),
                   Triangle(a, b, c).Area() / 3});
  cases.push_back({"faces of an octahedron that share a corner",
                   Triangle({0, 0, 1}, {0, 1, 0}, {1, 0, 0}),
                   Triangle({0, 0, 1}, {0, -1, 0}, {-1, 0, 0}), 0.128986791870356393});
  cases.push_back({"opposed triangles", Triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                   Triangle({0, 0, 0.8}, {0, 1, 0.8}, {1, 0, 0.8}), 0.0791896895518376691});
  cases.push_back({"a sliver far off", Triangle({0, 0, 0}, {1, 0, 0}, {1, 1e-4, 0}),
                   Quad({0, -0.5, 1}, {0, 0.5, 1}, {1, 0.5, 1}, {1, -0.5, 1}),
                   0.0000109275301881368315, 0.2185e-6});
  // Squares through each other's middle see half of each other.
  cases.push_back({"squares that cross", Floor(1, 1),
                   Quad({0.5, 0, -0.5}, {0.5, 0, 0.5}, {0.5, 1, 0.5}, {0.5, 1, -0.5}),
                   RightAngle(1, 0.5, 0.5)});
  cases.push_back(
      {"a millionth of the size", Floor(1, 1),
       Quad({0.3, 0.6, 0.5}, {0.3, 0.600001, 0.5}, {0.300001, 0.600001, 0.5}, {0.300001, 0.6, 0.5}),
       5.10219725470313194e-13, 0.51e-6});
  cases.push_back({"squares in one plane", Floor(1, 1),
                   Quad({2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 1, 0}), 0, 0});
  cases.push_back({"back to back", Floor(1, 1), Ceiling(1, 1, -1), 0, 0});
  cases.push_back({"facing away", Floor(1, 1), Floor(1, 1, 1), 0, 0});
  return cases;
}

// In both orders, turned at random about the origin, moved by some sizes, scaled.
void Check(const ExactCase& exact) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Random random(seed);
    testing::Motion motion;
    if (seed > 0) {
      motion = testing::RandomRotation(random);
      motion.offset = 3.0 * testing::RandomDirection(random);
    }
    for (const double scale : {1.0, 1e-6, 1e6}) {
      motion.scale = scale;
      ConvexPolygon p = motion(exact.p), q = motion(exact.q);
      const double scale2 = scale * scale;
      const double least = std::min(exact.p.Area(), exact.q.Area());
      const double bound = exact.tolerance * least;
      const CouplingEnd end_p = MakeCouplingEnd(p), end_q = MakeCouplingEnd(q);
      const PairCoupling one = Couple(end_p, end_q, 1e-8 * least * scale2);
      const PairCoupling other = Couple(end_q, end_p, 1e-8 * least * scale2);
      EXPECT_NEAR(one.coupling_m2 / scale2, exact.coupling_m2, bound)
          << exact.name << ", motion " << seed << ", scale " << scale;
      EXPECT_EQ(one.coupling_m2, other.coupling_m2) << exact.name;
    }
  }
}

TEST(ExactCases, AreMetWithinTheirTolerance) {
  for (const ExactCase& exact : ExactCases()) Check(exact);
}

TEST(ExactCases, AreMetByTheReference) {
  for (const ExactCase& exact : ExactCases()) {
    const auto reference = static_cast<double>(testing::CouplingByContours(exact.p, exact.q));
    EXPECT_NEAR(reference, exact.coupling_m2,
                1e-11 * exact.coupling_m2 + 1e-15 * std::sqrt(exact.p.Area() * exact.q.Area()))
        << exact.name;
  }
}

double PointFactor(const Vec3& x, const Vec3& n, const ConvexPolygon& polygon) {
  const ClippedPolygon q = ClipToFront(polygon, x, n, 0);
  return PointFormFactors(Vec3x4({x, x, x, x}), n, q.corners())[0];
}

TEST(ExactCases, OfPointsAreMet) {
  const Vec3 up(0, 0, 1);
  EXPECT_NEAR(PointFactor({0, 0, 0}, up, Ceiling(1, 1, 1)), testing::PointUnderCorner(1, 1, 1),
              1e-14);
  // A wall of which a part is below the floor's plane.
  const ConvexPolygon wall = Quad({1, 0, -0.5}, {1, 0, 1.5}, {1, 1, 1.5}, {1, 1, -0.5});
  EXPECT_NEAR(PointFactor({0, 0.3, 0}, up, wall),
              testing::PointBeforeUpright(1.5, 0.3, 1) + testing::PointBeforeUpright(1.5, 0.7, 1),
              1e-14);
}

TEST(Reference, AgreesWithItselfByAnotherWay) {
  int compared = 0;
  for (uint64_t seed = 1; compared < 20; ++seed) {
    const testing::PolygonPair pair = testing::MakePair(testing::PairFamilies()[1], seed);
    const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
    const ClippedPolygon p_front = ClipToFront(pair.p, pair.q.v[0], q.normal, 0);
    const ClippedPolygon q_front = ClipToFront(pair.q, pair.p.v[0], p.normal, 0);
    if (p_front.Area() < (1 - 1e-12) * p.area_m2 || q_front.Area() < (1 - 1e-12) * q.area_m2) {
      continue;
    }
    EXPECT_NEAR(static_cast<double>(testing::CouplingByPoints(pair.p, pair.q, 1e-12L)),
                static_cast<double>(testing::CouplingByContours(pair.p, pair.q)), 1e-10)
        << "seed " << seed;
    ++compared;
  }
}

// --- The collection of exact cases: exact_cases.json in the shared folder.

nlohmann::json Collection() {
  std::ifstream file(testing::SharedFolder() + "/exact_cases.json");
  return file ? nlohmann::json::parse(file).at("cases") : nlohmann::json();
}

Vec3 PointOf(const nlohmann::json& point) { return {point[0], point[1], point[2]}; }

ConvexPolygon PolygonOf(const nlohmann::json& corners) {
  ConvexPolygon polygon;
  for (const auto& corner : corners) polygon.v[polygon.count++] = PointOf(corner);
  return polygon;
}

double Number(const nlohmann::json& text) { return std::stod(text.get<std::string>()); }

void CheckBox(const nlohmann::json& box) {
  const Vec3 size = PointOf(box.at("geometry").at("box"));
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      if (i == j) continue;
      const ConvexPolygon p = testing::BoxFace(size, i), q = testing::BoxFace(size, j);
      Check({box.at("id").get<std::string>() + " " + std::to_string(i) + std::to_string(j), p, q,
             Number(box.at("value").at("F")[i][j]) * p.Area()});
    }
  }
}

void CheckPoint(const nlohmann::json& given) {
  const auto& geometry = given.at("geometry");
  const Vec3 x = PointOf(geometry.at("point")), n = PointOf(geometry.at("normal"));
  EXPECT_NEAR(PointFactor(x, n, PolygonOf(geometry.at("surface_2"))),
              Number(given.at("value").at("F")), 1e-14)
      << given.at("id");
}

TEST(ExactCases, OfTheCollectionAreMet) {
  const nlohmann::json collection = Collection();
  if (collection.is_null()) GTEST_SKIP() << "no collection of exact cases beside the source tree";
  int checked = 0;
  for (const auto& given : collection) {
    const auto group = given.at("group").get<std::string>();
    const auto id = given.at("id").get<std::string>();
    if (id == "ngon32_coaxial_d1") continue;  // of many polygons: exact_shapes_test.cc
    if (group == "polygon_pair" || group == "clipping") {
      const ConvexPolygon p = PolygonOf(given.at("geometry").at("surface_1"));
      const ConvexPolygon q = PolygonOf(given.at("geometry").at("surface_2"));
      const auto& value = given.at("value");
      const double exact = value.contains("C12")     ? Number(value.at("C12"))
                           : value.contains("value") ? Number(value.at("value"))
                                                     : Number(value.at("F12")) * p.Area();
      const bool relative = id.find("sliver") != std::string::npos || id == "scale_ratio_1e6";
      Check({id, p, q, exact, relative ? 1e-6 * exact / std::min(p.Area(), q.Area()) : 1e-8});
    } else if (group == "box_matrix") {
      CheckBox(given);
    } else if (group == "point_polygon") {
      CheckPoint(given);
    } else {
      continue;
    }
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

}  // namespace
}  // namespace isolux
