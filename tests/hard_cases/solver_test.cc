// Hard cases of the solvers: furnaces, extreme reflectances and emissions, channels unlike each
// other, rooms that hardly touch. Over full matrices of exact couplings where the solver alone is
// meant, over links where the couplings belong to the case.
#include "worker/radiosity/solver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/util/random.h"
#include "tests/hard_cases/hard_case.h"
#include "tests/support/dense_transport.h"
#include "tests/support/link_bench.h"
#include "tests/support/scenes.h"
#include "worker/radiosity/closure.h"

namespace isolux::testing {
namespace {

constexpr SolverMethod kCg = SolverMethod::kConjugateGradients;
constexpr SolverMethod kMethods[] = {kCg, SolverMethod::kJacobi, SolverMethod::kGaussSeidel,
                                     SolverMethod::kChebyshev, SolverMethod::kSouthwell};

Lanes Grey(double v) { return Lanes{v, v, v, 0}; }

std::vector<Lanes> Dark(size_t n) { return std::vector<Lanes>(n, Lanes{}); }

SolverOptions ToAccuracy(double accuracy, uint32_t most_products = 500) {
  SolverOptions options;
  options.accuracy = accuracy;
  options.max_products = most_products;
  return options;
}

SolverResult SolveOver(Transport& transport, const LeafSystem& leaves, const SolverOptions& options,
                       SolverMethod method = kCg) {
  NullExchange exchange;
  return Solve(method, transport, leaves, Dark(leaves.size()), options, exchange).value();
}

SolverResult SolveDense(const GridBox& box, const SolverOptions& options,
                        SolverMethod method = kCg) {
  DenseTransport transport(box.coupling_m2, box.leaves);
  return SolveOver(transport, box.leaves, options, method);
}

SolverResult SolveLinks(LinkBench& bench, const SolverOptions& options) {
  LinkTransport transport(*bench.product, bench.system);
  return SolveOver(transport, bench.system, options);
}

std::vector<Lanes> RadiosityOf(const LeafSystem& leaves, const SolverResult& solved) {
  std::vector<Lanes> radiosity(leaves.size());
  for (size_t i = 0; i < leaves.size(); ++i)
    radiosity[i] = leaves.exitance[i] + leaves.reflectance[i] * solved.irradiance[i];
  return radiosity;
}

double LargestOf(const std::vector<Lanes>& values) {
  double largest = 0;
  for (const Lanes& v : values)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(v[c]));
  return largest;
}

// Σ A E and Σ A (1 − ρ) H in one channel, W.
struct Balance {
  double emitted_w = 0, absorbed_w = 0;
};
Balance BalanceOf(const LeafSystem& leaves, std::span<const Lanes> irradiance, int c = 0) {
  Balance balance;
  for (size_t i = 0; i < leaves.size(); ++i) {
    balance.emitted_w += leaves.area_m2[i] * leaves.exitance[i][c];
    balance.absorbed_w += leaves.area_m2[i] * (1 - leaves.reflectance[i][c]) * irradiance[i][c];
  }
  return balance;
}

// Random grey reflectances below `most`, and emission on a fifth of the leaves.
void Paint(uint64_t seed, double most, LeafSystem* leaves) {
  Random random(seed);
  for (size_t i = 0; i < leaves->size(); ++i) {
    leaves->reflectance[i] = Grey(most * random.Unit());
    leaves->exitance[i] = Grey(random.Unit() < 0.2 ? random.Unit() : 0.0);
  }
}

// Couplings off by up to 5 %, alike both ways, in single precision as links have them.
void AddNoise(uint64_t seed, GridBox* box) {
  Random random(seed);
  const size_t n = box->leaves.size();
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) {
      const double noisy = box->coupling_m2[i * n + k] * (1 + 0.05 * (2 * random.Unit() - 1));
      box->coupling_m2[i * n + k] = box->coupling_m2[k * n + i] = static_cast<float>(noisy);
    }
  }
}

std::string Seed(uint64_t seed) { return "seed " + std::to_string(seed); }

TEST(HardSolver, WhiteFurnace) {
  HardCase even("22",
                "white furnace, full matrix of 5 % noise in single precision, closed to 1e-10",
                "|B(1-rho)/E - 1| (1-rho) is at most the closure's residual", 1e-10);
  HardCase short_way("22a", "white furnace, rho .5 to .99999", "products, from darkness", 40);
  for (const double rho : {0.5, 0.9, 0.99, 0.999, 0.99999}) {
    for (const std::array<double, 3> size : {std::array<double, 3>{1, 1, 1}, {1, 1, 20}}) {
      GridBox box = MakeGridBox(size, {3, 3, size[2] > 1 ? 15 : 3});
      const size_t n = box.leaves.size();
      AddNoise(22, &box);
      CloseDense(box.coupling_m2, 1e-10, &box.leaves);
      box.leaves.reflectance.assign(n, Grey(rho));
      box.leaves.exitance.assign(n, Grey(3.0));
      const SolverResult solved = SolveDense(box, ToAccuracy(1e-9));
      const std::string where = fmt::format("rho {}, 1:{}", rho, size[2]);
      for (const Lanes& b : RadiosityOf(box.leaves, solved))
        even.Measure(std::abs(b[0] * (1 - rho) / 3.0 - 1) * (1 - rho), where);
      short_way.Measure(solved.products, where);
    }
  }
}

TEST(HardSolver, WhiteFurnaceOverLinks) {
  HardCase even("22b", "white furnace over links, closed as far as it goes", "|B(1-rho)/E - 1|",
                1e-6);
  for (const double rho : {0.5, 0.9, 0.99, 0.999, 0.99999}) {
    LinkBench bench(FurnaceCube(rho, 3.0), 1e-2 / (1 - rho));
    const auto closing = bench.CloseRows(1e-10);
    ASSERT_TRUE(closing.has_value());
    const SolverResult solved = SolveLinks(bench, ToAccuracy(1e-9));
    for (const Lanes& b : RadiosityOf(bench.system, solved)) {
      even.Measure(std::abs(b[0] * (1 - rho) / 3.0 - 1),
                   fmt::format("rho {}, closure to {:.2g}", rho, closing->worst_after));
    }
  }
}

TEST(HardSolver, KirchhoffFurnace) {
  HardCase one("23", "E = 1 - rho, random rho up to .99, full matrix of 5 % noise closed to 1e-7",
               "|B - 1| (1 - largest rho)", 1e-6);
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    GridBox box = MakeGridBox({1, 2, 3}, {4, 4, 4});
    AddNoise(seed, &box);
    CloseDense(box.coupling_m2, 1e-7, &box.leaves);
    Random random(seed);
    for (size_t i = 0; i < box.leaves.size(); ++i) {
      const double r = random.Unit(), g = random.Unit();
      box.leaves.reflectance[i] = 0.99 * Lanes{r, g, random.Unit(), 0};
      box.leaves.exitance[i] = Lanes{1, 1, 1, 0} - box.leaves.reflectance[i];
    }
    for (const Lanes& b : RadiosityOf(box.leaves, SolveDense(box, ToAccuracy(1e-7)))) {
      for (int c = 0; c < 3; ++c) one.Measure(std::abs(b[c] - 1) * (1 - 0.99), Seed(seed));
    }
  }
}

TEST(HardSolver, NothingReflects) {
  HardCase exact("24", "rho = 0 everywhere", "|B - E|", 0);
  HardCase one("24a", "rho = 0 everywhere, conjugate gradients", "products", 1);
  GridBox box = MakeGridBox({1, 2, 3}, {3, 3, 3});
  Paint(24, 0, &box.leaves);
  for (const SolverMethod method : kMethods) {
    const SolverResult solved = SolveDense(box, ToAccuracy(1e-6), method);
    const auto radiosity = RadiosityOf(box.leaves, solved);
    for (size_t i = 0; i < radiosity.size(); ++i)
      exact.Measure(std::abs(radiosity[i][0] - box.leaves.exitance[i][0]), ToText(method));
    if (method == kCg) one.Measure(solved.products);
  }
}

TEST(HardSolver, NothingEmits) {
  HardCase dark("25", "E = 0, from any start", "largest |H|", 0);
  HardCase idle("25a", "E = 0, from any start", "iterations", 0);
  GridBox box = MakeGridBox({1, 2, 3}, {3, 3, 3});
  Paint(25, 0.999, &box.leaves);
  box.leaves.exitance.assign(box.leaves.size(), Lanes{});
  for (const SolverMethod method : kMethods) {
    for (const double start : {0.0, 7.0}) {
      DenseTransport transport(box.coupling_m2, box.leaves);
      NullExchange exchange;
      const auto solved =
          Solve(method, transport, box.leaves, std::vector<Lanes>(box.leaves.size(), Grey(start)),
                ToAccuracy(0.02), exchange);
      ASSERT_TRUE(solved.has_value());
      dark.Measure(LargestOf(solved->irradiance), ToText(method));
      idle.Measure(solved->iterations, ToText(method));
    }
  }
}

TEST(HardSolver, MoreReturnsThanHasLeft) {
  HardCase told("26", "rho = 1 or 1.2 on all of a closed room", "solvers that do not say so", 0);
  for (const double rho : {1.0, 1.2}) {
    GridBox box = MakeGridBox({1, 2, 3}, {3, 3, 3});
    box.leaves.reflectance.assign(box.leaves.size(), Grey(rho));
    box.leaves.exitance[0] = Grey(1);
    for (const SolverMethod method : kMethods)
      told.Measure(SolveDense(box, ToAccuracy(0.02), method).indefinite ? 0 : 1, ToText(method));
  }
  HardCase refused("26a", "a scene with rho of 1, 1.2, -0.1 or not a number",
                   "scenes taken, or refused without the material's name", 0);
  for (const double rho : {1.0, 1.2, -0.1, std::nan("")}) {
    Scene scene = FurnaceCube(0.5, 1);
    scene.materials[2].reflectance.y = rho;
    const Status status = Validate(scene);
    const bool named = status.message().find(scene.materials[2].name) != std::string::npos;
    refused.Measure(!status.ok() && named ? 0 : 1, fmt::format("{}", rho));
  }
}

TEST(HardSolver, AllIsReflectedInAnOpenRoom) {
  HardCase conserved("27", "rho = 1, one side of the box missing",
                     "|escaped - emitted| / emitted, all solvers", 1e-8);
  GridBox box = MakeGridBox({1, 2, 3}, {4, 4, 4});
  const size_t n = box.leaves.size();
  box.leaves.reflectance.assign(n, Grey(1));
  box.leaves.exitance[n - 1] = Grey(5);
  // The missing side takes and gives nothing.
  std::vector<double> escape(n, 0);
  for (size_t k = 0; k < n; ++k) {
    if (box.face[k] != 0) continue;
    box.leaves.reflectance[k] = Lanes{};
    for (size_t i = 0; i < n; ++i) {
      escape[i] += box.coupling_m2[i * n + k] / box.leaves.area_m2[i];
      box.coupling_m2[i * n + k] = box.coupling_m2[k * n + i] = 0;
    }
  }
  for (const SolverMethod method : kMethods) {
    const SolverResult solved = SolveDense(box, ToAccuracy(1e-8), method);
    const auto radiosity = RadiosityOf(box.leaves, solved);
    double emitted = 0, escaped = 0;
    for (size_t i = 0; i < n; ++i) {
      emitted += box.leaves.area_m2[i] * box.leaves.exitance[i][0];
      escaped += box.leaves.area_m2[i] * escape[i] * radiosity[i][0];
    }
    conserved.Measure(std::abs(escaped / emitted - 1), ToText(method));
  }
}

TEST(HardSolver, TinyEmitters) {
  HardCase conserved("28", "an emitter of 1e-6 of the area with E from 1e-30 to 1e9",
                     "|absorbed - emitted| / emitted", 1e-6);
  HardCase linear("28a", "the same, E twice as much", "radiosities that are not twice, to the bit",
                  0);
  GridBox box = MakeGridBox({1, 2, 3}, {4, 4, 4});
  const size_t n = box.leaves.size();
  Paint(28, 0.95, &box.leaves);
  // Leaf 0 shrinks to a speck; the closure makes up for the rest of it.
  const double speck = 1e-6;
  for (size_t k = 0; k < n; ++k) {
    box.coupling_m2[k] *= speck;
    box.coupling_m2[k * n] *= speck;
  }
  box.leaves.area_m2[0] *= speck;
  CloseDense(box.coupling_m2, 1e-12, &box.leaves);
  for (const double exitance : {1e-30, 1.0, 1e9}) {
    std::vector<Lanes> once;
    for (const double factor : {1.0, 2.0}) {
      box.leaves.exitance.assign(n, Lanes{});
      box.leaves.exitance[0] = Grey(factor * exitance);
      const SolverResult solved = SolveDense(box, ToAccuracy(1e-7));
      const Balance balance = BalanceOf(box.leaves, solved.irradiance);
      const std::string where = fmt::format("E {}", exitance);
      conserved.Measure(std::abs(balance.absorbed_w / balance.emitted_w - 1), where);
      if (factor == 1.0) once = solved.irradiance;
      for (size_t i = 0; i < n; ++i)
        linear.Measure(solved.irradiance[i][0] == factor * once[i][0] ? 0 : 1, where);
    }
  }
}

// ---- frozen links of random rooms

class FrozenLinks {
 public:
  // Of a room with 0 to 3 blocks.
  void MeasureAll(uint64_t seed) {
    LinkBench bench(RandomRoom(seed, static_cast<int>(seed % 4)), 3e-2, 1, false);
    const LeafSystem untouched = bench.system;
    MeasureSymmetry(seed, bench, "");
    Superpose(seed, bench);
    bench.system = untouched;
    RaiseReflectances(seed, bench);
    bench.system = untouched;
    ASSERT_TRUE(bench.CloseRows(1e-3).has_value());
    MeasureSymmetry(seed, bench, ", closed");
  }

 private:
  void Superpose(uint64_t seed, LinkBench& bench) {
    const size_t n = bench.system.size();
    Random random(seed);
    std::vector<Lanes> a(n), b(n);
    for (size_t i = 0; i < n; ++i)
      (random.Unit() < 0.5 ? a : b)[i] = Lanes{random.Unit(), random.Unit(), 0, 0};
    std::array<std::vector<Lanes>, 3> radiosity;
    for (int which = 0; which < 3; ++which) {
      for (size_t i = 0; i < n; ++i) {
        bench.system.exitance[i] = which == 0 ? a[i] : which == 1 ? b[i] : a[i] + b[i];
      }
      radiosity[which] = RadiosityOf(bench.system, SolveLinks(bench, ToAccuracy(1e-12)));
    }
    const double largest = LargestOf(radiosity[2]);
    for (size_t i = 0; i < n; ++i) {
      const Lanes off = radiosity[0][i] + radiosity[1][i] - radiosity[2][i];
      sum_.Measure(LargestOf({off}) / largest, Seed(seed));
    }
  }

  void RaiseReflectances(uint64_t seed, LinkBench& bench) {
    Random random(seed);
    const auto before = RadiosityOf(bench.system, SolveLinks(bench, ToAccuracy(1e-13)));
    for (Lanes& rho : bench.system.reflectance) {
      if (random.Unit() < 0.2) rho += (0.95 - rho) * random.Unit();
      rho[3] = 0;
    }
    const auto after = RadiosityOf(bench.system, SolveLinks(bench, ToAccuracy(1e-13)));
    const double largest = LargestOf(after);
    for (size_t i = 0; i < after.size(); ++i) {
      for (int c = 0; c < 3; ++c)
        monotone_.Measure((before[i][c] - after[i][c]) / largest, Seed(seed));
    }
  }

  void MeasureSymmetry(uint64_t seed, LinkBench& bench, const std::string& where) {
    LinkTransport transport(*bench.product, bench.system);
    const size_t n = bench.system.size();
    const auto x = bench.RandomValues(2 * seed), z = bench.RandomValues(2 * seed + 1);
    std::vector<Lanes> kx(n), kz(n);
    ASSERT_TRUE(transport.Irradiance(x, Splat(1), kx).ok());
    ASSERT_TRUE(transport.Irradiance(z, Splat(1), kz).ok());
    for (int c = 0; c < 3; ++c) {
      ExactSum xkz, zkx;
      for (size_t i = 0; i < n; ++i) {
        xkz.Add(bench.system.area_m2[i] * x[i][c] * kz[i][c]);
        zkx.Add(bench.system.area_m2[i] * z[i][c] * kx[i][c]);
      }
      symmetric_.Measure(std::abs(xkz.Value() - zkx.Value()) / xkz.Value(), Seed(seed) + where);
    }
  }

  HardCase sum_{"29", "sources a, b and both, frozen links of random rooms",
                "|B_a + B_b - B_ab| over the largest", 1e-10};
  HardCase monotone_{"30", "some reflectances raised, frozen links of random rooms",
                     "largest fall of a radiosity over the largest", 1e-12};
  HardCase symmetric_{"40", "x.(K z) against z.(K x), after refinement and after closure",
                      "difference over x.(K z)", 1e-13};
};

TEST(HardSolver, FrozenLinksOfRandomRooms) {
  FrozenLinks rooms;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    rooms.MeasureAll(seed);
    if (HasFatalFailure()) return;
  }
}

// Two closed boxes; what arrives at a small share of one leaf of the first comes out of its
// counterpart in the second, as through frosted glass. Rows stay whole.
GridBox TwoRooms(double open_share) {
  const GridBox room = MakeGridBox({1, 2, 3}, {4, 4, 4});
  const size_t n = room.leaves.size(), all = 2 * n, door = n / 2;
  double total = 0;
  for (const double area : room.leaves.area_m2) total += area;
  const double open = open_share * total / room.leaves.area_m2[door];
  GridBox rooms;
  rooms.coupling_m2.assign(all * all, 0);
  for (int r = 0; r < 2; ++r) {
    for (size_t i = 0; i < n; ++i) {
      rooms.leaves.area_m2.push_back(room.leaves.area_m2[i] * (i == door ? 1 - open : 1));
      rooms.face.push_back(room.face[i]);
      for (size_t k = 0; k < n; ++k) {
        const double c = room.coupling_m2[i * n + k];
        rooms.coupling_m2[(r * n + i) * all + r * n + k] =
            c * (i == door || k == door ? 1 - open : 1);
        rooms.coupling_m2[(r * n + i) * all + (1 - r) * n + k] =
            i == door || k == door ? 0
                                   : open * room.coupling_m2[i * n + door] *
                                         room.coupling_m2[k * n + door] / room.leaves.area_m2[door];
      }
    }
  }
  rooms.leaves.reflectance.assign(all, Lanes{});
  rooms.leaves.exitance.assign(all, Lanes{});
  rooms.leaves.closure.assign(all, 1);
  return rooms;
}

TEST(HardSolver, TwoRoomsThatHardlyTouch) {
  HardCase few("34", "two rooms of rho .999 joined by 1e-4 of the area", "products", 60);
  HardCase balanced("34a", "the same", "|absorbed + net flow - emitted| / emitted in each room",
                    1e-8);
  GridBox rooms = TwoRooms(1e-4);
  const size_t n = rooms.leaves.size() / 2;
  rooms.leaves.reflectance.assign(2 * n, Grey(0.999));
  rooms.leaves.exitance[3] = Grey(10);
  const SolverResult solved = SolveDense(rooms, ToAccuracy(1e-7));
  few.Measure(solved.products);
  const auto radiosity = RadiosityOf(rooms.leaves, solved);
  double flow = 0;  // from the first into the second, W
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < n; ++k) {
      flow += rooms.coupling_m2[i * 2 * n + n + k] * (radiosity[i][0] - radiosity[n + k][0]);
    }
  }
  double emitted = 0;
  std::array<double, 2> absorbed{};
  for (size_t i = 0; i < 2 * n; ++i) {
    emitted += rooms.leaves.area_m2[i] * rooms.leaves.exitance[i][0];
    absorbed[i / n] += rooms.leaves.area_m2[i] * 0.001 * solved.irradiance[i][0];
  }
  ASSERT_GT(flow, 0.01 * emitted);
  balanced.Measure(std::abs(absorbed[0] + flow - emitted) / emitted, "lit room");
  balanced.Measure(std::abs(absorbed[1] - flow) / emitted, "dark room");
}

TEST(HardSolver, ComponentsThatDoNotTouch) {
  HardCase dark("35", "two closed rooms, one without light", "largest |B| in the dark one", 0);
  GridBox rooms = TwoRooms(0);
  const size_t n = rooms.leaves.size() / 2;
  Paint(35, 0.99, &rooms.leaves);
  for (size_t i = n; i < 2 * n; ++i) rooms.leaves.exitance[i] = Lanes{};
  for (const SolverMethod method : kMethods) {
    const SolverResult solved = SolveDense(rooms, ToAccuracy(1e-3), method);
    for (size_t i = n; i < 2 * n; ++i)
      dark.Measure(std::abs(solved.irradiance[i][0]), ToText(method));
  }
}

TEST(HardSolver, LongPastConvergence) {
  HardCase unchanged("38", "conjugate gradients continued 100 iterations past convergence",
                     "largest change of a radiosity over the largest", 1e-12);
  const auto compare = [&](const LeafSystem& leaves, const SolverResult& at_end,
                           const SolverResult& past, const std::string& where) {
    const auto a = RadiosityOf(leaves, at_end), b = RadiosityOf(leaves, past);
    const double largest = LargestOf(a);
    for (size_t i = 0; i < a.size(); ++i) {
      for (int c = 0; c < 3; ++c) unchanged.Measure(std::abs(a[i][c] - b[i][c]) / largest, where);
    }
  };
  constexpr double kNever = 1e-300;
  for (const double rho : {0.5, 0.99, 0.99999}) {
    GridBox box = MakeGridBox({1, 2, 3}, {4, 4, 4});
    Paint(38, rho, &box.leaves);
    for (size_t i = 0; i < box.leaves.size(); i += 2) box.leaves.reflectance[i] = Grey(rho);
    const SolverResult at_end = SolveDense(box, ToAccuracy(1e-13));
    const SolverResult past = SolveDense(box, ToAccuracy(kNever, at_end.products + 100));
    EXPECT_GT(past.products, at_end.products);
    compare(box.leaves, at_end, past, fmt::format("rho {}", rho));
  }
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    LinkBench bench(RandomRoom(seed, 3), 1e-2);
    const SolverResult at_end = SolveLinks(bench, ToAccuracy(1e-13));
    const SolverResult past = SolveLinks(bench, ToAccuracy(kNever, at_end.products + 100));
    EXPECT_GT(past.products, at_end.products);
    compare(bench.system, at_end, past, Seed(seed));
  }
}

TEST(HardSolver, ChannelsUnlikeEachOther) {
  HardCase alone("39", "rho of 0, .999 and .3 side by side, over links and full matrices",
                 "radiosities that are not those of the channel alone, to the bit", 0);
  const Lanes rho{0, 0.999, 0.3, 0};
  const auto measure = [&](LeafSystem& leaves, Transport& transport, const std::string& where) {
    Random random(39);
    const size_t n = leaves.size();
    for (size_t i = 0; i < n; ++i) {
      leaves.reflectance[i] = rho;
      leaves.exitance[i] =
          random.Unit() < 0.2 ? Lanes{1, random.Unit(), 100 * random.Unit(), 0} : Lanes{};
    }
    const auto together = RadiosityOf(leaves, SolveOver(transport, leaves, ToAccuracy(1e-12)));
    const std::vector<Lanes> all = leaves.exitance;
    for (int c = 0; c < 3; ++c) {
      for (size_t i = 0; i < n; ++i) {
        leaves.reflectance[i] = leaves.exitance[i] = Lanes{};
        leaves.reflectance[i][c] = rho[c];
        leaves.exitance[i][c] = all[i][c];
      }
      const auto single = RadiosityOf(leaves, SolveOver(transport, leaves, ToAccuracy(1e-12)));
      for (size_t i = 0; i < n; ++i)
        alone.Measure(single[i][c] == together[i][c] ? 0 : 1,
                      fmt::format("{}, channel {}", where, c));
    }
  };
  GridBox box = MakeGridBox({1, 2, 3}, {4, 4, 4});
  DenseTransport dense(box.coupling_m2, box.leaves);
  measure(box.leaves, dense, "full matrix");
  for (const uint64_t seed : {1, 2, 3}) {
    LinkBench bench(seed == 1 ? FurnaceCube(0.5, 1) : RandomRoom(seed, 3), 1e-2, 1, false);
    LinkTransport links(*bench.product, bench.system);
    ASSERT_TRUE(bench.CloseRows(1e-6).has_value());
    measure(bench.system, links, fmt::format("links of room {}", seed));
  }
}

}  // namespace
}  // namespace isolux::testing
