#include "worker/radiosity/given.h"

namespace isolux {
namespace {

// Elements smaller than this share of the scene are at the resolution of ray casting in float.
constexpr double kSmallestElement = 1e-6;

bool IsDivisible(const Tree& tree, uint32_t node) {
  const double smallest_m = kSmallestElement * tree.hierarchy().extent_m();
  return tree.node(node).id.level() < kMaxLevel && tree.area_m2(node) > smallest_m * smallest_m;
}

}  // namespace

std::vector<GivenIrradiance> GivenTo(std::span<const uint32_t> nodes, const Tree& tree,
                                     const LightField& field, ThreadPool& pool) {
  std::vector<GivenIrradiance> given(nodes.size());
  pool.For(nodes.size(), 64, [&](size_t begin, size_t end, int) {
    for (size_t i = begin; i < end; ++i) {
      given[i] = field.Over(tree.node(nodes[i]).id, tree.polygon(nodes[i]));
    }
  });
  return given;
}

Result<std::vector<uint32_t>> DivideForLights(double epsilon_w, const LightField& field, Tree& tree,
                                              Placement& placement, ThreadPool& pool,
                                              RefineCounters& counters,
                                              const std::function<bool()>& cancelled) {
  std::vector<uint32_t> asked, wave, next;
  // What lies above the cut every worker judges alike, and goes on where it is at home.
  const auto add = [&](uint32_t node) {
    if (!placement.InCrown(node) && !placement.IsMine(node)) return;
    if (field.MostPower(tree.node(node).id, tree.polygon(node)) > epsilon_w) {
      next.push_back(node);
    } else if (placement.IsMine(node)) {
      asked.push_back(node);  // too little to look closely
    }
  };
  for (uint32_t s = 0; s < tree.hierarchy().surfaces().size(); ++s) add(tree.SurfaceIndex(s));
  while (!next.empty()) {
    if (cancelled && cancelled()) return Error(StatusCode::kCancelled, "refinement was cancelled");
    wave.swap(next);
    next.clear();
    const std::vector<GivenIrradiance> given = GivenTo(wave, tree, field, pool);
    for (size_t i = 0; i < wave.size(); ++i) {
      const uint32_t node = wave[i];
      const uint32_t owner = placement.OwnerCut(node, node);
      if (placement.assignment().home[owner] == placement.self()) {
        ++counters.evaluations;
        ++counters.evaluations_of_cut[owner];
        counters.light_rays += given[i].rays;
      }
      if (given[i].range * tree.area_m2(node) > epsilon_w && IsDivisible(tree, node)) {
        const uint32_t child = tree.MakeChildren(node);
        placement.Extend(tree);
        add(child);
        add(child + 1);
      } else if (placement.IsMine(node)) {
        asked.push_back(node);
      }
    }
  }
  return asked;
}

template <typename V>
LeafSystemOf<V> WithReflectedGiven(const LeafSystemOf<V>& leaves) {
  LeafSystemOf<V> result = leaves;
  for (size_t i = 0; i < leaves.size(); ++i) {
    result.exitance[i] += leaves.reflectance[i] * leaves.given[i];
  }
  return result;
}

template <typename V>
Result<SolverResultOf<V>> SolveWithGiven(const LeafSystemOf<V>& leaves,
                                         std::type_identity_t<std::span<const V>> start,
                                         double accuracy, const SolveFunction<V>& solve) {
  if (leaves.given.empty()) return solve(leaves, start, accuracy);
  // What comes from lights is known; the rest is what leaves that reflect it bring to each other.
  std::vector<V> rest(start.begin(), start.end());
  for (size_t i = 0; i < rest.size(); ++i) rest[i] = Maximum(rest[i] - leaves.given[i], V{});
  ASSIGN_OR_RETURN(SolverResultOf<V> result, solve(WithReflectedGiven(leaves), rest, accuracy));
  for (size_t i = 0; i < rest.size(); ++i) result.irradiance[i] += leaves.given[i];
  return result;
}

#define ISOLUX_FOR(V)                                                                           \
  template LeafSystemOf<V> WithReflectedGiven(const LeafSystemOf<V>&);                          \
  template Result<SolverResultOf<V>> SolveWithGiven(const LeafSystemOf<V>&, std::span<const V>, \
                                                    double, const SolveFunction<V>&);
ISOLUX_FOR(Single)
ISOLUX_FOR(Lanes)
#undef ISOLUX_FOR

}  // namespace isolux
