// What must be hidden and what must be seen, at the level of form factors: partitions, boxes,
// pinholes, wires, louvres, gaps of a billionth.
#include <gtest/gtest.h>

#include <map>

#include "tests/hard_cases/hard_case.h"
#include "tests/support/factor_scenes.h"
#include "tests/support/polygons.h"
#include "worker/factors/factors.h"

namespace isolux {
namespace {

using testing::AxisRectangle;
using testing::CornersOf;
using testing::HardCase;

using Polygons = std::vector<ConvexPolygon>;

FactorTable Compute(const Polygons& polygons, double tolerance) {
  ThreadPool pool(2);
  return ComputeFactors(testing::MakeScene(polygons), {.tolerance = tolerance}, pool).value();
}

ConvexPolygon Reversed(ConvexPolygon polygon) {
  std::reverse(polygon.v.begin(), polygon.v.begin() + polygon.count);
  return polygon;
}

// The six walls of a box as n × n panels each, fronts inwards; `open` walls (x low, x high, y low,
// …) are left out.
Polygons BoxInside(const Vec3& low, const Vec3& high, int n, const std::vector<int>& open = {}) {
  Polygons polygons;
  for (int face = 0; face < 6; ++face) {
    if (std::find(open.begin(), open.end(), face) != open.end()) continue;
    const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool upper = face % 2 == 1;
    const auto at = [&](int d, int i) { return low[d] + (high[d] - low[d]) * i / n; };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        polygons.push_back(AxisRectangle(axis, upper ? high[axis] : low[axis], at(u, i),
                                         at(u, i + 1), at(v, j), at(v, j + 1), !upper));
      }
    }
  }
  return polygons;
}

// A wall across x = `at` over the unit square with a square hole in its middle: eight polygons,
// four to either side.
Polygons WallWithHole(double at, double hole) {
  const double a = 0.5 - 0.5 * hole, b = 0.5 + 0.5 * hole;
  Polygons polygons;
  for (const bool up : {true, false}) {
    polygons.push_back(AxisRectangle(0, at, 0, 1, 0, a, up));
    polygons.push_back(AxisRectangle(0, at, 0, 1, b, 1, up));
    polygons.push_back(AxisRectangle(0, at, 0, a, a, b, up));
    polygons.push_back(AxisRectangle(0, at, b, 1, a, b, up));
  }
  return polygons;
}

void Append(Polygons* to, const Polygons& more) { to->insert(to->end(), more.begin(), more.end()); }

// Σ C between polygons of rooms up to x = low and of rooms from x = high on; walls across x belong
// to the room that their front is in.
double CouplingAcross(const Polygons& polygons, const FactorTable& table, double low, double high) {
  const auto side = [&](uint32_t end) {
    const ConvexPolygon& polygon = polygons[table.ends[end].polygon];
    const Vec3 inside = polygon.Centroid() + 1e-3 * polygon.Normal();
    Bounds3 box;
    for (const Vec3& v : CornersOf(polygon)) box.Add(v);
    if (box.high.x <= low && inside.x < low) return -1;
    return box.low.x >= high && inside.x > high ? 1 : 0;
  };
  double sum = 0;
  for (const Factor& factor : table.factors) {
    if (side(factor.p) * side(factor.q) == -1) sum += factor.coupling_m2;
  }
  return sum;
}

PairFactor SolveAmong(const OccluderSet& set, const ConvexPolygon& p, const ConvexPolygon& q,
                      double tolerance) {
  const OccluderTree tree(set);
  PairSolver solver(tree);
  std::vector<uint32_t> all(set.size());
  for (uint32_t i = 0; i < set.size(); ++i) all[i] = i;
  const CouplingEnd from = MakeCouplingEnd(p), to = MakeCouplingEnd(q);
  return solver.Solve({from}, {to}, all, tolerance * std::min(from.area_m2, to.area_m2), 1);
}

TEST(HardVisibility, FullPartition) {
  HardCase dark("15f",
                "closed box with a full partition, 1 to 5 panels a side, straddling it or not",
                "sum of couplings from one half to the other", 0);
  for (int n = 1; n <= 5; ++n) {
    Polygons polygons = BoxInside(Vec3(0.0), Vec3(1.0), n);
    const ConvexPolygon wall = AxisRectangle(0, 0.5, 0, 1, 0, 1, true);
    polygons.push_back(wall);
    polygons.push_back(Reversed(wall));
    dark.Measure(CouplingAcross(polygons, Compute(polygons, 1e-3), 0.5, 0.5),
                 fmt::format("{} panels", n));
  }
}

TEST(HardVisibility, PartitionOfManyPieces) {
  HardCase dark("16f", "partition of 2 triangles, of 1000 slivers, not joined into one",
                "F from one half to the other", 1e-12);
  for (const int strips : {1, 500}) {
    OccluderSet set(2);
    for (int i = 0; i < strips; ++i) {
      const double a = static_cast<double>(i) / strips, b = static_cast<double>(i + 1) / strips;
      const ConvexPolygon strip = AxisRectangle(0, 0.5, a, b, 0, 1, true);
      set.Add(std::array{strip.v[0], strip.v[1], strip.v[2]});
      set.Add(std::array{strip.v[0], strip.v[2], strip.v[3]});
    }
    const ConvexPolygon left = AxisRectangle(0, 0, 0, 1, 0, 1, true);
    for (const ConvexPolygon& right :
         {AxisRectangle(0, 1, 0, 1, 0, 1, false), AxisRectangle(2, 0, 0.5, 1, 0, 1, true)}) {
      const PairFactor pair = SolveAmong(set, left, right, 1e-3);
      dark.Measure(pair.coupling_m2, fmt::format("{} strips", strips));
    }
  }
}

TEST(HardVisibility, CoverJustAbove) {
  HardCase close("17f", "cover 1e-3 to 1e-9 over the middle of an emitter",
                 "|F - that of the uncovered frame|, over the distance + 1e-6", 1);
  HardCase all("17g", "cover of the whole emitter, 1e-3 to 1e-9 above it", "F past it", 0);
  const ConvexPolygon low = AxisRectangle(2, 0, 0, 1, 0, 1, true);
  const ConvexPolygon high = AxisRectangle(2, 1, 0, 1, 0, 1, false);
  for (const double gap : {1e-3, 1e-6, 1e-9}) {
    OccluderSet middle(2), whole(2);
    middle.Add(CornersOf(AxisRectangle(2, gap, .25, .75, .25, .75, true)));
    whole.Add(CornersOf(AxisRectangle(2, gap, -gap, 1 + gap, -gap, 1 + gap, true)));
    const double f = SolveAmong(middle, low, high, 1e-6).coupling_m2;
    close.Measure(std::abs(f - 0.1427096886977442) / (gap + 1e-6), fmt::format("gap {:g}", gap));
    all.Measure(SolveAmong(whole, low, high, 1e-6).coupling_m2, fmt::format("gap {:g}", gap));
  }
}

// No panel may shadow its neighbours in one wall, nor a wall itself.
TEST(HardVisibility, NoAcne) {
  HardCase rows("17h", "room of 240 panels, turned, its coordinates printed with six digits",
                "|row sum - 1| at 1e-4", 1e-3);
  Random random(3);
  const Vec3 axis = testing::RandomDirection(random);
  testing::PanelledRoom room;
  room.panels = {8, 6, 5};
  room.with_box = false;
  Scene scene = testing::MakePanelledRoom(room);
  for (Vec3& v : scene.vertices) {  // half a turn about the axis
    v = 2.0 * glm::dot(axis, v) * axis - v;
    for (int d = 0; d < 3; ++d) v[d] = std::round(v[d] * 1e5) / 1e5;
  }
  ThreadPool pool(2);
  const FactorTable table = ComputeFactors(scene, {.tolerance = 1e-4}, pool).value();
  for (const FactorEnd& end : table.ends) {
    rows.Measure(std::abs(end.row_sum_before - 1), fmt::format("polygon {}", end.polygon));
  }
}

TEST(HardVisibility, WiresAndLouvres) {
  HardCase within("18f", "wire 1e-3 wide, louvre of 100 slats, 1e-2 to 1e-4",
                  "error over the tolerance", 1);
  HardCase stated("18g", "the same", "error over three times what was stated", 1);
  const ConvexPolygon low = AxisRectangle(2, 0, 0, 1, 0, 1, true);
  const ConvexPolygon high = AxisRectangle(2, 1, 0, 1, 0, 1, false);
  OccluderSet wire(2), louvre(2);
  wire.Add(CornersOf(AxisRectangle(2, 0.4, 0.3, 0.301, -1, 2, true)));
  for (int i = 0; i < 100; ++i) {
    louvre.Add(CornersOf(AxisRectangle(0, (i + 0.5) / 100, 0, 1, 0.5, 0.51, true)));
  }
  for (const OccluderSet* set : {&wire, &louvre}) {
    const double exact = SolveAmong(*set, low, high, 1e-6).coupling_m2;
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
      const PairFactor pair = SolveAmong(*set, low, high, tolerance);
      const double error = std::abs(pair.coupling_m2 - exact);
      const std::string where = fmt::format("{} at {:g}, {}", set == &wire ? "wire" : "louvre",
                                            tolerance, ToText(pair.way));
      within.Measure(error / tolerance, where);
      stated.Measure(error / (3 * pair.error_m2), where);
    }
  }
}

// All that passes a hole is what a black wall in its place would take up: its own area's worth.
TEST(HardVisibility, Pinhole) {
  HardCase through("19f", "two closed rooms joined by a hole of 1e-2", "|sum of C / hole - 1|",
                   0.05);
  constexpr double kHole = 1e-2;
  Polygons polygons = BoxInside(Vec3(0.0), Vec3(1.0), 1, {1});
  Append(&polygons, BoxInside(Vec3(1, 0, 0), Vec3(2, 1, 1), 1, {0}));
  Append(&polygons, WallWithHole(1, kHole));
  const double sum = CouplingAcross(polygons, Compute(polygons, 1e-7), 1, 1);
  through.Measure(std::abs(sum / (kHole * kHole) - 1));
}

TEST(HardVisibility, TwoPinholes) {
  HardCase through("19g", "three rooms in a row joined by holes of 0.1",
                   "|sum of C past both / C of the holes - 1|", 0.05);
  constexpr double kHole = 0.1;
  Polygons polygons = BoxInside(Vec3(0.0), Vec3(1.0), 1, {1});
  Append(&polygons, BoxInside(Vec3(1, 0, 0), Vec3(2, 1, 1), 1, {0, 1}));
  Append(&polygons, BoxInside(Vec3(2, 0, 0), Vec3(3, 1, 1), 1, {0}));
  Append(&polygons, WallWithHole(1, kHole));
  Append(&polygons, WallWithHole(2, kHole));
  const double a = 0.5 - 0.5 * kHole, b = 0.5 + 0.5 * kHole;
  const ConvexPolygon first = AxisRectangle(0, 1, a, b, a, b, true);
  const ConvexPolygon second = AxisRectangle(0, 2, a, b, a, b, false);
  const double exact = Couple(MakeCouplingEnd(first), MakeCouplingEnd(second), 1e-10).coupling_m2;
  const double sum = CouplingAcross(polygons, Compute(polygons, 1e-6), 1, 2);
  through.Measure(std::abs(sum / exact - 1));
}

TEST(HardVisibility, LightInAClosedBox) {
  HardCase dark("49f", "closed box of thin walls inside a closed room",
                "sum of couplings between inside and outside", 0);
  const Vec3 low(0.3, 0.2, 0.4), high(0.6, 0.7, 0.8);
  const Polygons inside = BoxInside(low, high, 2), outside = BoxInside(Vec3(0.0), Vec3(1.0), 2);
  Polygons polygons = inside;
  for (const ConvexPolygon& polygon : inside) polygons.push_back(Reversed(polygon));
  Append(&polygons, outside);
  const FactorTable table = Compute(polygons, 1e-3);
  double sum = 0;
  for (const Factor& factor : table.factors) {
    const bool p = table.ends[factor.p].polygon < inside.size();
    const bool q = table.ends[factor.q].polygon < inside.size();
    if (p != q) sum += factor.coupling_m2;
  }
  dark.Measure(sum);
}

// A room with a box of a millimetre on a box on its floor, as coordinates a million sizes from the
// origin leave it.
TEST(HardVisibility, FarFromTheOrigin) {
  HardCase same("4v", "a box of 1e-3 on a box in a room, moved by 10^3 to 10^6 sizes and back",
                "pairs seen in one place and hidden in another", 0);
  HardCase close("4w", "the same",
                 "change of C over the stated errors and 1e-7 of the smaller area", 1);
  const auto room = [](double shift) {
    Polygons polygons = BoxInside(Vec3(0.0), Vec3(1.0), 3);
    const auto add = [&](const Vec3& low, const Vec3& high) {
      for (ConvexPolygon wall : BoxInside(low, high, 1)) polygons.push_back(Reversed(wall));
    };
    add({0.4, 0.4, 0}, {0.6, 0.6, 0.3});
    add({0.5, 0.5, 0.3}, {0.501, 0.501, 0.301});
    const Vec3 by = shift * Vec3(0.6, -0.48, 0.64);
    for (ConvexPolygon& polygon : polygons) {
      for (int i = 0; i < polygon.count; ++i) polygon.v[i] = (polygon.v[i] + by) - by;
    }
    return polygons;
  };
  constexpr double kTolerance = 1e-4;
  const auto couplings = [&](double shift) {
    const FactorTable table = Compute(room(shift), kTolerance);
    std::map<std::pair<uint32_t, uint32_t>, Factor> found;
    for (const Factor& factor : table.factors) found[{factor.p, factor.q}] = factor;
    return std::pair(table, found);
  };
  const auto [table, here] = couplings(0);
  for (const double shift : {1e3, 1e4, 1e5, 1e6}) {
    const auto there = couplings(shift).second;
    for (uint32_t q = 0; q < table.ends.size(); ++q) {
      for (uint32_t p = 0; p < q; ++p) {
        const auto a = here.find({p, q}), b = there.find({p, q});
        const Factor none;
        const Factor &one = a == here.end() ? none : a->second,
                     &other = b == there.end() ? none : b->second;
        const double smaller = std::min(table.ends[p].area_m2, table.ends[q].area_m2);
        const double most = std::max(one.coupling_m2, other.coupling_m2);
        const bool apart = (one.coupling_m2 > 0) != (other.coupling_m2 > 0);
        const std::string where = fmt::format("{} and {}, {:g}", p, q, shift);
        same.Measure(apart && most > 1e-7 * smaller ? 1 : 0, where);
        close.Measure(std::abs(one.coupling_m2 - other.coupling_m2) /
                          (one.error_m2 + other.error_m2 + 1e-7 * smaller),
                      where);
      }
    }
  }
}

TEST(HardVisibility, BoxOnTheFloor) {
  HardCase above("14f", "box on a floor, gap 0, 1e-9 and -1e-9", "how far row sums are above 1", 0);
  HardCase rows("14g", "the same, but for what is under the box", "|row sum - 1| at 1e-4", 1e-3);
  HardCase dark("14h", "floor under a sunk box", "row sum", 1e-8);
  for (const double gap : {0.0, 1e-9, -1e-9}) {
    testing::PanelledRoom room;
    room.panels = {6, 5, 4};
    room.low = {2, 2};
    room.high = {4, 3};
    room.height_m = 0.8;
    room.gap_m = gap;
    const Scene scene = testing::MakePanelledRoom(room);
    ThreadPool pool(2);
    const FactorTable table = ComputeFactors(scene, {.tolerance = 1e-4}, pool).value();
    for (const FactorEnd& end : table.ends) {
      const ConvexPolygon shape = SideGeometry(scene, end.polygon, Side::kFront);
      const Vec3 c = shape.Centroid();
      const bool inside = c.x > 1 && c.x < 2 && c.y > 1 && c.y < 1.5;
      const bool hidden = inside && std::abs(c.z) < 1e-6;
      const std::string where = fmt::format("gap {:g}, polygon {}", gap, end.polygon);
      above.Measure(std::max(0.0, end.row_sum - 1), where);
      if (!hidden) rows.Measure(std::abs(end.row_sum_before - 1), where);
      if (hidden && gap < 0 && shape.Normal().z > 0) dark.Measure(end.row_sum, where);
    }
  }
}

}  // namespace
}  // namespace isolux
