// A shard without its rounds: the parts of a one-process solve laid open, with its links.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "common/util/random.h"
#include "worker/radiosity/ambient.h"
#include "worker/radiosity/closure.h"
#include "worker/radiosity/escape.h"
#include "worker/radiosity/matvec.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/solver.h"

namespace isolux::testing {

// What a scout of a closed room of one component would find, without its rays.
inline Scout ClosedWithoutLooking(const Hierarchy& hierarchy) {
  const size_t n = hierarchy.surfaces().size();
  Scout scout;
  scout.escape.assign(n, 0);
  scout.closed.assign(n, 1);
  scout.component.assign(n, 0);
  return scout;
}

// The parts of a shard laid open, refined once to a share of the emitted power.
struct LinkBench {
  // scouted: whether rays look for components and for light that escapes, which takes longer than
  // all the rest of a small room.
  LinkBench(Scene scene_in, double share, int threads = 2, bool scouted = true, uint64_t seed = 1)
      : scene(std::move(scene_in)),
        pool(threads),
        hierarchy(scene),
        rays(hierarchy),
        tree(hierarchy) {
    const Scout scout =
        scouted ? ScoutEscapes(hierarchy, rays, Mirrors(), TranslucentSheets(), 0.02, 1, pool)
                : ClosedWithoutLooking(hierarchy);
    const Snapshot start = AmbientSnapshot(hierarchy, scout, {}, {}, {});
    tree.SetComponents(scout.component);
    double emitted = 0;
    for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s)
      emitted += hierarchy.surface_area_m2(s) * Sum(hierarchy.surfaces()[s].exitance);
    std::vector<uint32_t> moved;
    EXPECT_TRUE(tree.Install(start, &moved).ok());
    placement = std::make_unique<Placement>(
        Placement::Make(tree, {{{NodeId::kCluster, 0}}, {0}, 1}, 0).value());
    epsilon_w = share * emitted;
    EXPECT_TRUE(Refine(epsilon_w, {&rays, seed, !hierarchy.convex()}, tree, *placement, pool, links,
                       counters, nullptr)
                    .ok());
    nodes = Subscribe(tree, *placement, links, {}, exchange).value();
    product = std::make_unique<Product>(tree, *placement, links, nodes, pool, exchange);
    for (const uint32_t node : nodes.leaves) {
      const Surface& surface = tree.surface_of(node);
      system.area_m2.push_back(tree.area_m2(node));
      system.reflectance.push_back(
          Lanes{surface.reflectance.x, surface.reflectance.y, surface.reflectance.z, 0});
      system.exitance.push_back(
          Lanes{surface.exitance.x, surface.exitance.y, surface.exitance.z, 0});
      system.closure.push_back(1);
      system.inheritance.push_back(1);
      system.returned.push_back(0);
    }
  }

  std::vector<Lanes> RandomValues(uint64_t seed) const {
    Random random(seed);
    std::vector<Lanes> values(system.size());
    for (Lanes& v : values) v = Lanes{random.Unit(), random.Unit(), random.Unit(), 0};
    return values;
  }

  // Closes the rows as those of a closed room so bright that nothing in it is rather a lamp.
  Result<ClosureSummary> CloseRows(double tolerance) {
    return Close(*product, system, std::vector<Lanes>(system.size(), Splat(1e9)),
                 std::vector<RowMeasure>(system.size()), RowsMay::kRiseAndFall, {.row = tolerance},
                 exchange);
  }

  std::vector<Lanes> Irradiance(const std::vector<Lanes>& radiosity) {
    std::vector<Lanes> result(radiosity.size());
    EXPECT_TRUE(product->Irradiance(radiosity, Splat(1), result).ok());
    return result;
  }

  Scene scene;
  ThreadPool pool;
  Hierarchy hierarchy;
  RayScene rays;
  Tree tree;
  std::unique_ptr<Placement> placement;
  LinkSet links;
  RefineCounters counters;
  NullExchange exchange;
  ActiveNodes nodes;
  std::unique_ptr<Product> product;
  LeafSystem system;
  double epsilon_w = 0;
};

}  // namespace isolux::testing
