// What lights bring to the elements of a worker: which elements must be there for it, and how much
// each leaf gets.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "common/util/parallel.h"
#include "common/util/status.h"
#include "worker/radiosity/light_field.h"
#include "worker/radiosity/placement.h"
#include "worker/radiosity/refine.h"
#include "worker/radiosity/solver.h"

namespace isolux {

// Divides elements from the surfaces down until what lights bring is even enough: range of the
// irradiance times area ≤ epsilon. Returns those of the last division that are homed here: leaves
// must not lie above them. They follow from the scene and epsilon alone.
Result<std::vector<uint32_t>> DivideForLights(double epsilon_w, const LightField& field, Tree& tree,
                                              Placement& placement, ThreadPool& pool,
                                              RefineCounters& counters,
                                              const std::function<bool()>& cancelled);

// What reaches these elements or surfaces.
std::vector<GivenIrradiance> GivenTo(std::span<const uint32_t> nodes, const Tree& tree,
                                     const LightField& field, ThreadPool& pool);

// Leaves that radiate E + ρH0, so that what they receive from each other is H − H0: to a solver
// what lights bring is exitance.
template <typename V>
LeafSystemOf<V> WithReflectedGiven(const LeafSystemOf<V>& leaves);

// By such a solver: the irradiance that lights and leaves bring together.
template <typename V>
Result<SolverResultOf<V>> SolveWithGiven(const LeafSystemOf<V>& leaves,
                                         std::type_identity_t<std::span<const V>> start,
                                         double accuracy, const SolveFunction<V>& solve);

}  // namespace isolux
