// What couplings of two polygons cost and how exact they are. Prints CSV:
// benchmark,quantity,value,unit. Run a name to run one, or nothing for all.
//
//   families    mean and largest time of a pair by how the two lie to each other and by tolerance,
//               and the largest error, in tolerances, against the same at 1e-11
//   refinement  pairs that a refinement of the Cornell box visits: share and mean time by rule
//   hard        time of pairs that once were slow: needles 1:1e5 at their own width, a square of
//               1e-6 or 1e-9 that stands on a floor
//   matrix      all pairs of 654 elements of the Cornell box on two threads, at 1e-4
//
// Tolerances are shares of the smaller area. Times are of this machine and this moment; the largest
// time of a pair is the least of five tries, so that it is the pair's and not the machine's.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <functional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "common/hierarchy/element.h"
#include "tests/support/scenes.h"
#include "tests/worker/coupling/random_pairs.h"
#include "worker/coupling/coupling.h"
#include "worker/coupling/variation.h"

namespace isolux {
namespace {

using testing::MakePair;
using testing::PairFamilies;
using testing::PairFamily;
using testing::PolygonPair;

double Now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Of this thread: what others do on the machine counts less.
double ProcessorNow() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void Print(const char* benchmark, const std::string& quantity, double value, const char* unit) {
  std::printf("%s,%s,%.3g,%s\n", benchmark, quantity.c_str(), value, unit);
  std::fflush(stdout);
}

std::string ToText(double tolerance) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0e", tolerance);
  return text;
}

const char* ToText(Regime regime) {
  constexpr std::array<const char*, kRegimes> kNames{"zero",   "negligible",  "midpoint", "kernel",
                                                     "points", "many points", "contour"};
  return kNames[static_cast<size_t>(regime)];
}

// Ends with the polygons they refer to.
struct Pairs {
  std::vector<PolygonPair> polygons;
  std::vector<CouplingEnd> p, q;

  void MakeEnds() {
    for (const PolygonPair& pair : polygons) {
      p.push_back(MakeCouplingEnd(pair.p));
      q.push_back(MakeCouplingEnd(pair.q));
    }
  }
  size_t size() const { return polygons.size(); }
  double Least(size_t i) const { return std::min(p[i].area_m2, q[i].area_m2); }
  PairCoupling CoupleAt(size_t i, double tolerance) const {
    return Couple(p[i], q[i], tolerance * Least(i));
  }
};

// Seconds that one run takes, the least of five.
double LeastTime(const std::function<void()>& run, double (*now)() = ProcessorNow) {
  double least = INFINITY;
  for (int i = 0; i < 5; ++i) {
    const double start = now();
    run();
    least = std::min(least, now() - start);
  }
  return least;
}

double MeanTime(const Pairs& pairs, std::span<const size_t> which, double tolerance) {
  volatile double sink = 0;
  return LeastTime([&] {
           for (const size_t i : which) sink = sink + pairs.CoupleAt(i, tolerance).coupling_m2;
         }) /
         static_cast<double>(which.size());
}

std::vector<size_t> All(const Pairs& pairs) {
  std::vector<size_t> all(pairs.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  return all;
}

void BenchFamilies() {
  for (const PairFamily& family : PairFamilies()) {
    Pairs pairs;
    for (uint64_t seed = 1; seed <= 10000; ++seed) pairs.polygons.push_back(MakePair(family, seed));
    pairs.MakeEnds();
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8}) {
      const std::string name = std::string(family.name) + " at " + ToText(tolerance);
      double slowest = 0, worst = 0;
      for (size_t i = 0; i < pairs.size(); ++i) {
        slowest = std::max(slowest, LeastTime([&] { pairs.CoupleAt(i, tolerance); }, Now));
        const double error = std::abs(pairs.CoupleAt(i, tolerance).coupling_m2 -
                                      pairs.CoupleAt(i, 1e-11).coupling_m2);
        worst = std::max(worst, error / (tolerance * pairs.Least(i)));
      }
      Print("families", name + " mean", 1e6 * MeanTime(pairs, All(pairs), tolerance), "us");
      Print("families", name + " slowest", 1e6 * slowest, "us");
      Print("families", name + " worst error", worst, "tolerances");
    }
  }
}

std::vector<ConvexPolygon> Surfaces() {
  const Scene scene = testing::CornellBox(true);
  std::vector<ConvexPolygon> surfaces;
  for (const Surface& surface : MakeSurfaces(scene)) {
    surfaces.push_back(SideGeometry(scene, surface.polygon, surface.side));
  }
  return surfaces;
}

// Pairs are divided at the larger end until what they exchange is below a threshold.
Pairs RefinementPairs() {
  const std::vector<ConvexPolygon> surfaces = Surfaces();
  double area = 0;
  for (const ConvexPolygon& surface : surfaces) area += surface.Area();
  Pairs pairs;
  std::vector<PolygonPair> stack;
  for (size_t i = 0; i < surfaces.size(); ++i) {
    for (size_t j = i + 1; j < surfaces.size(); ++j) stack.push_back({surfaces[i], surfaces[j]});
  }
  while (!stack.empty()) {
    const PolygonPair pair = stack.back();
    stack.pop_back();
    pairs.polygons.push_back(pair);
    const CouplingEnd p = MakeCouplingEnd(pair.p), q = MakeCouplingEnd(pair.q);
    if (Couple(p, q, 1e-3 * std::min(p.area_m2, q.area_m2)).coupling_m2 < 1e-5 * area) continue;
    const bool first = p.area_m2 > q.area_m2;
    for (const ConvexPolygon& child : Subdivide(first ? pair.p : pair.q)) {
      stack.push_back(first ? PolygonPair{child, pair.q} : PolygonPair{pair.p, child});
    }
  }
  pairs.MakeEnds();
  return pairs;
}

void BenchRefinement() {
  const Pairs pairs = RefinementPairs();
  Print("refinement", "pairs", static_cast<double>(pairs.size()), "");
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    std::array<std::vector<size_t>, kRegimes> by_regime;
    for (size_t i = 0; i < pairs.size(); ++i) {
      by_regime[static_cast<size_t>(pairs.CoupleAt(i, tolerance).regime)].push_back(i);
    }
    const std::string at = " at " + ToText(tolerance);
    Print("refinement", "mean" + at, 1e9 * MeanTime(pairs, All(pairs), tolerance), "ns");
    for (int r = 0; r < kRegimes; ++r) {
      if (by_regime[r].empty()) continue;
      const std::string name = ToText(static_cast<Regime>(r)) + at;
      Print("refinement", name + " share",
            100.0 * static_cast<double>(by_regime[r].size()) / static_cast<double>(pairs.size()),
            "%");
      Print("refinement", name + " mean", 1e9 * MeanTime(pairs, by_regime[r], tolerance), "ns");
    }
  }
  volatile double sink = 0;
  const double seconds = LeastTime([&] {
    for (size_t i = 0; i < pairs.size(); ++i) {
      sink = sink + RangesOver(pairs.p[i], pairs.q[i]).over_p.high;
    }
  });
  Print("refinement", "variation of the form factor, mean",
        1e9 * seconds / static_cast<double>(pairs.size()), "ns");
}

// The largest element is divided until there are enough.
std::vector<ConvexPolygon> Elements(size_t count) {
  std::vector<ConvexPolygon> elements = Surfaces();
  const auto smaller = [](const ConvexPolygon& a, const ConvexPolygon& b) {
    return a.Area() < b.Area();
  };
  std::make_heap(elements.begin(), elements.end(), smaller);
  while (elements.size() < count) {
    std::pop_heap(elements.begin(), elements.end(), smaller);
    const ConvexPolygon largest = elements.back();
    elements.pop_back();
    for (const ConvexPolygon& child : Subdivide(largest)) {
      elements.push_back(child);
      std::push_heap(elements.begin(), elements.end(), smaller);
    }
  }
  return elements;
}

void BenchHard() {
  const auto measure = [](const std::string& name, const PolygonPair& polygons) {
    Pairs pairs;
    pairs.polygons = {polygons};
    pairs.MakeEnds();
    for (const double tolerance : {1e-3, 1e-8}) {
      const std::string at = name + " at " + ToText(tolerance);
      Print("hard", at, 1e6 * MeanTime(pairs, All(pairs), tolerance), "us");
      Print("hard", at + ", pieces", pairs.CoupleAt(0, tolerance).pieces, "");
    }
  };
  constexpr double kWidth = 1e-5;
  const auto quad = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return ConvexPolygon{4, {a, b, c, d}};
  };
  measure("strips",
          {quad({0, 0, 0}, {1, 0, 0}, {1, kWidth, 0}, {0, kWidth, 0}),
           quad({0, kWidth, kWidth}, {1, kWidth, kWidth}, {1, 0, kWidth}, {0, 0, kWidth})});
  measure("needles",
          {{3, {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.4, kWidth, 0)}},
           {3, {Vec3(0, 0, kWidth), Vec3(0.7, kWidth, kWidth), Vec3(1, 0, 1.5 * kWidth)}}});
  const ConvexPolygon floor = quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0});
  for (const double size : {1e-6, 1e-9}) {
    for (const double y : {0.0, 0.5}) {
      const double x = 0.37;
      measure("square of " + ToText(size) + (y > 0 ? " on the floor" : " on its edge"),
              {floor, quad({x, y, 0}, {x, y, size}, {x + size, y, size}, {x + size, y, 0})});
    }
  }
}

void BenchMatrix() {
  constexpr size_t kElements = 654;
  constexpr double kTolerance = 1e-4;
  const std::vector<ConvexPolygon> elements = Elements(kElements);
  std::vector<CouplingEnd> ends;
  ends.reserve(elements.size());
  for (const ConvexPolygon& element : elements) ends.push_back(MakeCouplingEnd(element));
  const auto rows = [&](size_t first) {
    double sum = 0;
    for (size_t i = first; i < kElements; i += 2) {
      for (size_t j = 0; j < i; ++j) {
        const double least = std::min(ends[i].area_m2, ends[j].area_m2);
        sum += Couple(ends[i], ends[j], kTolerance * least).coupling_m2;
      }
    }
    return sum;
  };
  volatile double sink = 0;
  const double seconds = LeastTime(
      [&] {
        double other_sum = 0;
        std::thread other([&] { other_sum = rows(1); });
        const double sum = rows(0);
        other.join();
        sink = sum + other_sum;
      },
      Now);
  constexpr double kPairs = kElements * (kElements - 1) / 2.0;
  Print("matrix", "pairs", kPairs, "");
  Print("matrix", "pairs a second on two threads", kPairs / seconds, "1/s");
}

int Main(int argc, char** argv) {
  const std::vector<std::pair<const char*, std::function<void()>>> benchmarks = {
      {"families", BenchFamilies},
      {"refinement", BenchRefinement},
      {"hard", BenchHard},
      {"matrix", BenchMatrix}};
  std::printf("benchmark,quantity,value,unit\n");
  bool any = false;
  for (const auto& [name, run] : benchmarks) {
    if (argc > 1 && std::strcmp(argv[1], name) != 0) continue;
    run();
    any = true;
  }
  if (!any) std::fprintf(stderr, "coupling_bench: no benchmark is called %s\n", argv[1]);
  return any ? 0 : 2;
}

}  // namespace
}  // namespace isolux

int main(int argc, char** argv) { return isolux::Main(argc, argv); }
