// What the oracle says of a link against what the link errs by, found by brute force over random
// pairs of elements: each term is at least a stated share of the true error everywhere, and at most
// so many times as large in the middle. The reference has none of the solver's code below it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "common/util/random.h"
#include "tests/support/factor_scenes.h"
#include "tests/support/polygons.h"
#include "tests/worker/coupling/random_pairs.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/variation.h"
#include "worker/radiosity/refine.h"

namespace isolux {
namespace {

using testing::MakePair;
using testing::PairFamilies;
using testing::PairFamily;
using testing::PolygonPair;

using Corners = std::vector<Vec3>;

// ---- the reference

// Form factor from a point of a plane to what lies in front of it, [Lambert60].
double FactorTo(const Vec3& x, const Vec3& n, const Corners& q, const Vec3& q_normal) {
  if (glm::dot(q_normal, x - q[0]) <= 0) return 0;
  Corners front;
  for (size_t i = 0; i < q.size(); ++i) {
    const Vec3 a = q[i] - x, b = q[(i + 1) % q.size()] - x;
    const double ha = glm::dot(n, a), hb = glm::dot(n, b);
    if (ha >= 0) front.push_back(a);
    if ((ha < 0) != (hb < 0)) front.push_back(a + ha / (ha - hb) * (b - a));
  }
  double sum = 0;
  for (size_t i = 0; i < front.size(); ++i) {
    const Vec3 &a = front[i], &b = front[(i + 1) % front.size()], c = glm::cross(a, b);
    const double length = glm::length(c);
    if (length > 0) sum -= std::atan2(length, glm::dot(a, b)) * glm::dot(n, c) / length;
  }
  return std::max(0.0, sum / (2 * std::numbers::pi));
}

struct Cell {
  Corners corners;
  Vec3 middle{0.0};
  double area_m2 = 0;
};

// A polygon in n² triangles of one size for each triangle that it is made of.
std::vector<Cell> Divided(const ConvexPolygon& polygon, int n) {
  std::vector<Cell> cells;
  for (int k = 2; k < polygon.count; ++k) {
    const Vec3& o = polygon.v[0];
    const Vec3 s = (polygon.v[k - 1] - o) / static_cast<double>(n),
               t = (polygon.v[k] - o) / static_cast<double>(n);
    const auto at = [&](int i, int j) {
      return o + static_cast<double>(i) * s + static_cast<double>(j) * t;
    };
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
      cells.push_back({{a, b, c}, (a + b + c) / 3.0, 0.5 * glm::length(glm::cross(s, t))});
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }
  return cells;
}

// Form factors from the middles of the cells of p to each cell of q.
struct Exchange {
  std::vector<Cell> p, q;
  std::vector<double> factors;  // p.size() × q.size()

  Exchange(const PolygonPair& pair, int n) : p(Divided(pair.p, n)), q(Divided(pair.q, n)) {
    const Vec3 p_normal = pair.p.Normal(), q_normal = pair.q.Normal();
    for (const Cell& at : p) {
      for (const Cell& to : q)
        factors.push_back(FactorTo(at.middle, p_normal, to.corners, q_normal));
    }
  }
  // Irradiance at the cells of p from a radiosity of each cell of q.
  template <typename Radiosity>
  std::vector<double> Irradiance(const Radiosity& radiosity) const {
    std::vector<double> result;
    for (size_t i = 0; i < p.size(); ++i) {
      double sum = 0;
      for (size_t j = 0; j < q.size(); ++j) sum += factors[i * q.size() + j] * radiosity(j);
      result.push_back(sum);
    }
    return result;
  }
  double Power(const std::vector<double>& irradiance) const {
    double sum = 0;
    for (size_t i = 0; i < p.size(); ++i) sum += p[i].area_m2 * irradiance[i];
    return sum;
  }
};

// ---- the oracle

constexpr double kCouplingTolerance = 1e-4;  // of the smaller area

// Two surfaces and the link between them as refinement makes it.
class OneLink {
 public:
  explicit OneLink(const PolygonPair& pair)
      : scene_(testing::MakeScene({pair.p, pair.q})), hierarchy_(scene_), tree_(hierarchy_) {
    const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
    const PairCoupling coupling = Couple(p, q, kCouplingTolerance * std::min(p.area_m2, q.area_m2));
    const FormFactorVariation variation =
        VariationWith(RangesOver(p, q), p, q, coupling.coupling_m2);
    link.p = tree_.SurfaceIndex(0);
    link.q = tree_.SurfaceIndex(1);
    link.unoccluded_m2 = static_cast<float>(coupling.coupling_m2);
    link.variation_p = static_cast<float>(variation.over_p);
    link.variation_q = static_cast<float>(variation.over_q);
    link.visible_share = 65535;
    link.visible_rays = Link::kProved;
    link.error_code = EncodeCouplingError(coupling.error_m2, coupling.coupling_m2);
  }
  // Where only q radiates.
  LinkError Error(const NodeValues& q) const { return ErrorOf(tree_, link, {}, q); }

  Link link;

 private:
  Scene scene_;
  Hierarchy hierarchy_;
  Tree tree_;
};

// What is stated over what is true.
struct Ratios {
  std::vector<double> values;

  void Add(double stated, double truth) {
    if (truth > 0) values.push_back(stated / truth);
  }
  double At(double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
  }
  void Print(const char* name) {
    std::printf("%s: %zu links, least %.3g, 1 %% %.3g, median %.3g, 99 %% %.3g\n", name,
                values.size(), At(0), At(0.01), At(0.5), At(0.99));
  }
};

constexpr int kCells = 4;

enum class Which : uint8_t { kOrdinary, kSharedSide, kSizeRatio };

Which KindOf(const PairFamily& family) {
  const std::string name = family.name;
  if (name == "shared side") return Which::kSharedSide;
  return name.starts_with("size ratio") ? Which::kSizeRatio : Which::kOrdinary;
}

// Pairs of each kind of family; body(pair, random, ratios of its kind).
template <typename Body>
std::array<Ratios, 3> OverLinks(uint64_t seeds, const Body& body) {
  std::array<Ratios, 3> ratios;
  for (const PairFamily& family : PairFamilies()) {
    const auto kind = static_cast<size_t>(KindOf(family));
    for (uint64_t seed = 1; seed <= seeds; ++seed) {
      Random random(Hash(seed, 61));
      body(MakePair(family, seed), random, &ratios[kind]);
    }
  }
  return ratios;
}

// Errors of less than a hundredth of what is exchanged, or than couplings may have, do not count.
double LeastThatCounts(const PolygonPair& pair, const OneLink& one) {
  return std::max(0.01 * one.link.unoccluded_m2,
                  2 * kCouplingTolerance * std::min(pair.p.Area(), pair.q.Area()));
}

// The receiver: ∫ |F(x→q) − mean| over p, of light of one radiosity.
TEST(Oracle, ReceiverVariation) {
  auto [ordinary, shared_side, size_ratio] =
      OverLinks(300, [](const PolygonPair& pair, Random&, Ratios* ratios) {
        const OneLink one(pair);
        const Exchange exchange(pair, kCells);
        const std::vector<double> irradiance = exchange.Irradiance([](size_t) { return 1.0; });
        const double mean = exchange.Power(irradiance) / pair.p.Area();
        double truth = 0;
        for (size_t i = 0; i < irradiance.size(); ++i) {
          truth += exchange.p[i].area_m2 * std::abs(irradiance[i] - mean);
        }
        if (truth < LeastThatCounts(pair, one)) return;
        ratios->Add(one.Error({.radiosity = 1}).total_w, truth);
      });
  ordinary.Print("receiver");
  shared_side.Print("receiver, shared side");
  size_ratio.Print("receiver, size ratio");
  EXPECT_GE(ordinary.values.size(), 1000U);
  EXPECT_GT(ordinary.At(0), 0.08);
  EXPECT_GT(ordinary.At(0.01), 0.6);
  EXPECT_LT(ordinary.At(0.5), 8);
  EXPECT_GT(shared_side.At(0), 1.5);
  EXPECT_LT(shared_side.At(0.5), 8);
  // The foot of something tiny just above p is sampled a twentieth beside it.
  EXPECT_GT(size_ratio.At(0), 0.01);
  EXPECT_GT(size_ratio.At(0.1), 0.5);
}

// The source: what a radiosity that rises evenly from one end of q to the other brings to p.
TEST(Oracle, SourceSpread) {
  auto [ordinary, shared_side, size_ratio] =
      OverLinks(300, [](const PolygonPair& pair, Random& random, Ratios* ratios) {
        const OneLink one(pair);
        const Exchange exchange(pair, kCells);
        const Vec3 along = testing::RandomDirection(random), centre = pair.q.Centroid();
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < pair.q.count; ++i) {
          low = std::min(low, glm::dot(along, pair.q.v[i] - centre));
          high = std::max(high, glm::dot(along, pair.q.v[i] - centre));
        }
        const std::vector<double> irradiance = exchange.Irradiance([&](size_t j) {
          return glm::dot(along, exchange.q[j].middle - centre) / (high - low);
        });
        double truth = 0;
        for (size_t i = 0; i < irradiance.size(); ++i) {
          truth += exchange.p[i].area_m2 * std::abs(irradiance[i]);
        }
        if (truth < LeastThatCounts(pair, one)) return;
        ratios->Add(one.Error({.spread = 1}).spread_p_w, truth);
      });
  ordinary.Print("source");
  shared_side.Print("source, shared side");
  EXPECT_GE(ordinary.values.size(), 1000U);
  EXPECT_GT(ordinary.At(0), 1);
  EXPECT_LT(ordinary.At(0.5), 55);
  // In a narrow wedge each point of p sees the point of q across from it, and F is 1 all over q.
  EXPECT_GT(shared_side.At(0), 0.015);
  EXPECT_GT(shared_side.At(0.1), 0.3);
}

// A part of q is hidden, and brighter than the rest: what p gets is less than visibility and mean
// say.
TEST(Oracle, VisibilityAndSourceTogether) {
  auto [ordinary, shared_side,
        size_ratio] = OverLinks(300, [](const PolygonPair& pair, Random& random, Ratios* ratios) {
    OneLink one(pair);
    const Exchange exchange(pair, kCells);
    const Vec3 along = testing::RandomDirection(random);
    const Vec3 border = exchange.q[random.Bits() % exchange.q.size()].middle;
    const double bright = 1 + 9 * random.Unit();
    const auto hidden = [&](size_t j) {
      return glm::dot(along, exchange.q[j].middle - border) > 0;
    };
    const auto radiosity = [&](size_t j) { return hidden(j) ? bright : 1.0; };
    double mean = 0, square = 0;
    for (size_t j = 0; j < exchange.q.size(); ++j) {
      mean += exchange.q[j].area_m2 * radiosity(j) / pair.q.Area();
      square += exchange.q[j].area_m2 * radiosity(j) * radiosity(j) / pair.q.Area();
    }
    const double all = exchange.Power(exchange.Irradiance([](size_t) { return 1.0; }));
    const auto seen_of = [&](size_t j) { return hidden(j) ? 0.0 : 1.0; };
    const double share = exchange.Power(exchange.Irradiance(seen_of)) / all;
    const double true_power =
        exchange.Power(exchange.Irradiance([&](size_t j) { return seen_of(j) * radiosity(j); }));
    one.link.visible_rays = static_cast<uint8_t>(std::lround(Link::kRays * share));
    one.link.visible_share = static_cast<uint16_t>(std::lround(65535 * share));
    const double truth = std::abs(share * all * mean - true_power);
    if (truth < LeastThatCounts(pair, one)) return;
    NodeValues values;
    values.radiosity = static_cast<float>(mean);
    values.deviation = static_cast<float>(std::sqrt(std::max(0.0, square - mean * mean)));
    ratios->Add(one.Error(values).visibility_p_w, truth);
  });
  ordinary.Print("visibility");
  shared_side.Print("visibility, shared side");
  size_ratio.Print("visibility, size ratio");
  EXPECT_GE(ordinary.values.size(), 1000U);
  EXPECT_GT(ordinary.At(0), 0.1);
  EXPECT_GT(ordinary.At(0.01), 0.8);
  EXPECT_LT(ordinary.At(0.5), 8);
  EXPECT_GT(shared_side.At(0), 0.35);
}

// A lamp strip of 1.3 m close to an element much smaller or much larger than it: corners alone see
// next to nothing of it, or nothing at all.
TEST(Oracle, ClosestPointsOfLongThings) {
  Ratios over_element, over_strip;
  for (uint64_t seed = 1; seed <= 1000; ++seed) {
    Random random(Hash(seed, 62));
    const double width = 0.01 + 0.03 * random.Unit(), size = std::pow(10, -2 + 2 * random.Unit());
    const double height = 0.005 + 0.05 * random.Unit(), x = 1.3 * random.Unit() - 0.65;
    const Vec3 corner(x - 0.5 * size, 0.02 * random.Unit() - 0.5 * size, height);
    PolygonPair pair;
    pair.p = {4,
              {corner, corner + Vec3(0, size, 0), corner + Vec3(size, size, 0),
               corner + Vec3(size, 0, 0)}};
    pair.q = testing::AxisRectangle(2, 0, -0.65, 0.65, 0, width, true);
    const OneLink one(pair);
    const auto range = [](const ConvexPolygon& of, const ConvexPolygon& to) {
      const Corners corners(to.v.begin(), to.v.begin() + to.count);
      double low = INFINITY, high = 0;
      for (const Cell& cell : Divided(of, 24)) {
        const double factor = FactorTo(cell.middle, of.Normal(), corners, to.Normal());
        low = std::min(low, factor);
        high = std::max(high, factor);
      }
      return high - low;
    };
    over_element.Add(one.link.variation_p, range(pair.p, pair.q));
    over_strip.Add(one.link.variation_q, range(pair.q, pair.p));
  }
  over_element.Print("element at a strip");
  over_strip.Print("strip at an element");
  EXPECT_GT(over_element.At(0), 0.8);
  EXPECT_LT(over_element.At(0.5), 1.1);
  EXPECT_GT(over_strip.At(0.05), 0.3);
  EXPECT_LT(over_strip.At(0.5), 1.1);
}

}  // namespace
}  // namespace isolux
