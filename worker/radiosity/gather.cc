#include "worker/radiosity/gather.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "worker/radiosity/gather_point.h"
#include "worker/radiosity/gather_sources.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {
namespace {

// Points lie so far inside their element, so that none is on an edge or in a contact.
constexpr double kInside = 1e-5;
// Right at a light irradiance has no bound; sums have: this many times the largest of any leaf.
constexpr double kMostGiven = 1024;

// Elements begin .. end lie below one leaf.
struct Run {
  uint32_t leaf;
  size_t begin, end;
};

Result<std::vector<Run>> RunsOf(const Tree& tree, std::span<const NodeId> elements) {
  std::vector<Run> runs;
  for (size_t i = 0; i < elements.size(); ++i) {
    const NodeId& id = elements[i];
    if (id.is_cluster() || id.surface >= tree.hierarchy().surfaces().size() ||
        id.level() > kMaxLevel) {
      return Error(StatusCode::kInvalidArgument, "gather: there is no element {}:{}", id.surface,
                   id.path);
    }
    const uint32_t leaf = tree.FindNearest(id);
    if (tree.node(leaf).first_child != kNoNode || !Contains(tree.node(leaf).id, id)) {
      return Error(StatusCode::kInvalidArgument, "gather: element {}:{} is above a leaf",
                   id.surface, id.path);
    }
    if (runs.empty() || runs.back().leaf != leaf) runs.push_back({leaf, i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

ConvexPolygon ShapeBelow(const Tree& tree, uint32_t leaf, const NodeId& element) {
  ConvexPolygon polygon = tree.polygon(leaf);
  for (int level = element.level() - tree.node(leaf).id.level() - 1; level >= 0; --level) {
    polygon = Subdivide(polygon)[(element.path >> level) & 1];
  }
  return polygon;
}

// The blocks of all nodes from a surface down to a leaf, kept from leaf to leaf as long as they
// serve.
class Descent {
 public:
  Descent(const Tree& tree, const SourceFinder& sources, const GatherOptions& options, double scale)
      : tree_(tree), sources_(sources), options_(options), scale_(scale) {}

  std::span<SourceBlock* const> To(uint32_t leaf) {
    const size_t depth = static_cast<size_t>(tree_.node(leaf).id.level()) + 1;
    std::vector<uint32_t> path(depth);
    for (size_t i = depth; i-- > 0; leaf = tree_.node(leaf).parent) path[i] = leaf;
    if (path_.empty() || path_[0] != path[0]) frame_ = FrameOf(tree_.normal(path[0]));
    while (blocks_.size() < depth) {
      owned_.push_back(std::make_unique<SourceBlock>());
      blocks_.push_back(owned_.back().get());
    }
    size_t same = 0;
    while (same < std::min(path_.size(), depth) && path_[same] == path[same]) ++same;
    for (; same < depth; ++same) {
      sources_.Fill(path[same], frame_, options_, scale_, *blocks_[same]);
    }
    path_ = std::move(path);
    return std::span(blocks_).first(depth);
  }

 private:
  const Tree& tree_;
  const SourceFinder& sources_;
  const GatherOptions& options_;
  double scale_;
  SurfaceFrame frame_;
  std::vector<uint32_t> path_;  // the nodes whose blocks are filled, from the surface down
  std::vector<std::unique_ptr<SourceBlock>> owned_;
  std::vector<SourceBlock*> blocks_;  // of owned_
};

}  // namespace

GatherOptions GatherOptionsFor(double accuracy, uint64_t seed) {
  GatherOptions options;
  options.even_share = 0.01 * accuracy;
  options.seed = seed;
  options.ray_share = std::min(2.5 * accuracy * accuracy, 0.01);
  // 64 rays a point for 2 %, 256 for 1 %; coarse links leave more in doubt. docs/numerics.md.
  options.most_rays = accuracy < 0.02 ? std::min(64 * (0.02 / accuracy) * (0.02 / accuracy), 1024.0)
                                      : std::min(64 * (accuracy / 0.02), 192.0);
  options.point_error = 0.2 * accuracy;
  options.open_share = std::max(0.01, 0.5 * accuracy);
  return options;
}

struct Gatherer::Impl {
  Impl(const Tree& t, const Placement& p, const LinkSet& links, const Snapshot& snapshot,
       const RayScene& r, const LightField* l, const RefineScene& b)
      : tree(t), placement(p), rays(r), lights(l), between(b), sources(t, p, links, snapshot, b) {
    largest = sources.largest_radiosity();
    if (lights == nullptr) return;
    for (const LeafRecord& leaf : snapshot.leaves) {
      for (const double h : leaf.irradiance) largest = std::max(largest, h);
    }
  }

  // What lights bring to places of one leaf.
  LightRays AddLights(uint32_t leaf, std::span<const GatherPlace> places, double scale) const {
    const SkyOpenings openings = lights->OpeningsOf(tree.node(leaf).id, tree.polygon(leaf));
    LightRays traced{.sky = openings.rays};
    for (const GatherPlace& place : places) {
      const Rgb given =
          lights->At({place.position, tree.normal(leaf), tree.surface_of(leaf).polygon, place.seed},
                     openings, &traced);
      for (int c = 0; c < 3; ++c) {
        place.sums[c] += std::llround(scale * std::min(given[c], kMostGiven * largest));
      }
    }
    return traced;
  }

  std::vector<GatherPlace> PlacesOf(const Run& run, std::span<const NodeId> elements,
                                    std::span<const uint8_t> corners, int64_t* sums) const {
    std::vector<GatherPlace> places;
    for (size_t e = run.begin; e < run.end; ++e) {
      const ConvexPolygon polygon = ShapeBelow(tree, run.leaf, elements[e]);
      const Vec3 centre = polygon.Centroid();
      const auto seed_of = [&](uint64_t place) {
        return Hash(elements[e].path, elements[e].surface, place);
      };
      if (!corners.empty() && (corners[e] & kCentre) != 0) {
        places.push_back({centre, seed_of(kCentre), sums + 12 * e});
        continue;
      }
      const double share =
          std::max(kInside, InsideShare(polygon, centre, rays.coordinate_noise_m()));
      for (int k = 0; k < polygon.count; ++k) {
        if (!corners.empty() && (corners[e] >> k & 1) == 0) continue;
        places.push_back({polygon.v[k] + share * (centre - polygon.v[k]),
                          seed_of(static_cast<uint64_t>(k)), sums + 12 * e + 3 * k});
      }
    }
    return places;
  }

  const Tree& tree;
  const Placement& placement;
  const RayScene& rays;
  const LightField* lights;
  RefineScene between;
  SourceFinder sources;
  double largest;  // radiosity and, where there are lights, irradiance of a leaf, W/m²
};

Gatherer::Gatherer(const Tree& tree, const Placement& placement, const LinkSet& links,
                   const Snapshot& snapshot, const RayScene& rays, const LightField* lights,
                   const RefineScene& between)
    : impl_(std::make_unique<Impl>(tree, placement, links, snapshot, rays, lights, between)) {}
Gatherer::~Gatherer() = default;

Result<GatherPart> Gatherer::AtCorners(std::span<const NodeId> elements,
                                       std::span<const uint8_t> corners,
                                       const GatherOptions& options, ThreadPool& pool) const {
  if (!corners.empty() && corners.size() != elements.size()) {
    return Error(StatusCode::kInvalidArgument, "gather: corners of {} elements for {}",
                 corners.size(), elements.size());
  }
  GatherPart part;
  part.sums.assign(12 * elements.size(), 0);
  if (!(impl_->largest > 0)) return part;
  part.exponent = 49 - std::ilogb(impl_->largest);
  const double scale = std::ldexp(1.0, part.exponent);
  ASSIGN_OR_RETURN(const std::vector<Run> runs, RunsOf(impl_->tree, elements));
  std::mutex counting;
  uint64_t straight = 0, mirrored = 0;
  LightRays to_lights;
  // Leaves next to each other share most of what is above them.
  constexpr size_t kLeavesTogether = 32;
  pool.For(runs.size(), kLeavesTogether, [&](size_t begin, size_t end, int) {
    Descent descent(impl_->tree, impl_->sources, options, scale);
    PointGather gather(impl_->rays, impl_->sources, impl_->tree.mirrors(), impl_->between);
    LightRays lit;
    for (size_t r = begin; r < end; ++r) {
      const std::vector<GatherPlace> places =
          impl_->PlacesOf(runs[r], elements, corners, part.sums.data());
      if (places.empty()) continue;
      const uint32_t leaf = runs[r].leaf;
      gather.SetLeaf(impl_->tree, leaf, impl_->sources.CareAt(leaf, options), scale);
      const std::span<SourceBlock* const> blocks = descent.To(leaf);
      for (const GatherPlace& place : places) gather.Evaluate(place, blocks);
      if (impl_->lights != nullptr && impl_->placement.IsMine(leaf)) {
        lit += impl_->AddLights(leaf, places, scale);
      }
    }
    std::lock_guard lock(counting);
    straight += gather.traced() - gather.traced_by_mirrors();
    mirrored += gather.traced_by_mirrors();
    to_lights += lit;
  });
  part.costs["occlusion"].rays = straight;
  part.costs["mirrors"].rays = mirrored;
  part.costs["lights"].rays = to_lights.lights;
  part.costs["sun"].rays = to_lights.sun;
  part.costs["sky"].rays = to_lights.sky;
  part.rays = straight + mirrored + to_lights.Total();
  return part;
}

}  // namespace isolux
