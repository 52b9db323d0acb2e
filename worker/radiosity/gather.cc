#include "worker/radiosity/gather.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "worker/coupling/point_factor.h"
#include "worker/radiosity/gather_sources.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

constexpr int kMostRays = 64;    // from one point to one source
constexpr int kVaryingRays = 4;  // at least, to a source whose seen part may differ from the hidden
// Points lie so far inside their element, so that none is on an edge or in a contact.
constexpr double kInside = 1e-5;

// A corner of an element, where irradiance is wanted.
struct Place {
  Vec3 position{0.0};
  uint64_t seed = 0;
  int64_t* sums = nullptr;  // three, one a channel
};

// A ray from a place to a source.
struct Pick {
  uint32_t source = 0;
  double weight = 0;     // of the kernel
  double radiosity = 1;  // where the ray ends, over that of the source
};

// Evaluates the sources of one leaf at its places, four at a time.
class LeafGather {
 public:
  LeafGather(const Tree& tree, const RayScene& rays, const SourceFinder& finder, uint32_t leaf,
             const LeafSources& found, double scale)
      : found_(found),
        finder_(finder),
        rays_(rays),
        normal_(tree.normal(leaf)),
        own_polygon_(tree.surface_of(leaf).polygon),
        scale_(scale),
        factor_(found.sources.size()),
        visibility_(found.sources.size()) {}

  // At most four places.
  void Evaluate(std::span<const Place> places) {
    std::array<Vec3, 4> position;
    for (size_t i = 0; i < 4; ++i) position[i] = places[std::min(i, places.size() - 1)].position;
    const Vec3x4 points(position);
    for (size_t s = 0; s < found_.sources.size(); ++s) {
      const Source& source = found_.sources[s];
      visibility_[s] = Splat(source.visibility);
      if (source.polygon.count == 0) {
        factor_[s] = ClusterFactors(points, normal_, source.point, source.facing_m2);
        continue;
      }
      const Lanes height = Dot(source.normal, points - source.point);
      const Lanes factor = PointFormFactors(points, normal_, source.polygon.corners());
      factor_[s] = Select(height > 0.0, factor, Splat(0.0));
    }
    for (size_t i = 0; i < places.size(); ++i) Look(places[i], static_cast<int>(i));
    std::array<IntLanes, 3> total{};
    for (size_t s = 0; s < found_.sources.size(); ++s) {
      const Lanes arriving = factor_[s] * visibility_[s] * scale_;
      for (int c = 0; c < 3; ++c) {
        total[c] += ToInteger(arriving * found_.sources[s].radiosity[c]);
      }
    }
    for (size_t i = 0; i < places.size(); ++i) {
      for (int c = 0; c < 3; ++c) places[i].sums[c] = total[c][i] + found_.even[c];
    }
  }

  uint64_t traced() const { return traced_; }

 private:
  // Replaces the links' visibility at one place by that of rays, where their share calls for some.
  void Look(const Place& place, int lane) {
    lane_ = lane;
    for (uint32_t s = 0; s < found_.sources.size(); ++s) {
      const Source& source = found_.sources[s];
      double wanted = source.rays * factor_[s][lane];
      if (source.varying != kNoNode && factor_[s][lane] > 0) {
        wanted = std::max(wanted, static_cast<double>(kVaryingRays));
      }
      if (!(wanted > 0)) continue;
      Random random(Hash(source.seed, place.seed));
      const int rays = std::min(kMostRays, static_cast<int>(wanted + random.Unit()));
      if (rays > 0) Aim(place, s, rays, random);
    }
    Trace();
    Settle();
  }

  void Aim(const Place& place, uint32_t s, int rays, Random& random) {
    const Source& source = found_.sources[s];
    ConvexPolygon target;
    target.count = std::min(source.polygon.count, 4);
    std::copy_n(source.polygon.v.begin(), target.count, target.v.begin());
    target = DrawnIn(target, rays_.coordinate_noise_m());
    // A shifted additive sequence: even over the source whatever the number of rays ([Roberts18]).
    constexpr double kStepU = 0.75487766624669276, kStepV = 0.56984029099805327;
    double u = random.Unit(), v = random.Unit();
    for (int k = 0; k < rays; ++k) {
      const Vec3 to = SamplePolygon(target, u, v);
      u += kStepU - (u + kStepU >= 1 ? 1 : 0);
      v += kStepV - (v + kStepV >= 1 ? 1 : 0);
      const Vec3 d = to - place.position;
      const double d2 = glm::dot(d, d);
      const double weight = std::max(0.0, glm::dot(normal_, d)) *
                            std::max(0.0, -glm::dot(source.normal, d)) / (d2 * d2);
      if (!(weight > 0)) continue;
      if (count_ == kPacketRays) Trace();
      segments_[count_] = {place.position, to, own_polygon_, source.surface_polygon};
      const double radiosity =
          source.varying == kNoNode ? 1.0 : finder_.RelativeRadiosityAt(source.varying, to);
      picks_[count_++] = {s, weight, radiosity};
    }
  }

  // Rays of one source may fall into two packets: sums go on while the source stays the same.
  void Trace() {
    if (count_ == 0) return;
    const uint32_t visible = rays_.Visible(segments_, count_);
    traced_ += static_cast<uint64_t>(count_);
    for (int i = 0; i < count_; ++i) {
      if (picks_[i].source != open_source_) {
        Settle();
        open_source_ = picks_[i].source;
      }
      total_ += picks_[i].weight;
      if ((visible >> i & 1) != 0) passed_ += picks_[i].weight * picks_[i].radiosity;
    }
    count_ = 0;
  }

  void Settle() {
    if (total_ > 0) visibility_[open_source_][lane_] = passed_ / total_;
    passed_ = total_ = 0;
    open_source_ = kNone;
  }

  static constexpr int kPacketRays = RayScene::kPacket;
  static constexpr uint32_t kNone = 0xffffffffu;

  const LeafSources& found_;
  const SourceFinder& finder_;
  const RayScene& rays_;
  const Vec3 normal_;
  const uint32_t own_polygon_;
  const double scale_;
  std::vector<Lanes> factor_, visibility_;  // by source
  std::array<Segment, RayScene::kPacket> segments_;
  std::array<Pick, RayScene::kPacket> picks_;
  int count_ = 0, lane_ = 0;
  uint32_t open_source_ = kNone;
  double passed_ = 0, total_ = 0;
  uint64_t traced_ = 0;
};

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

}  // namespace

struct Gatherer::Impl {
  Impl(const Tree& t, const Placement& placement, const LinkSet& links, const Snapshot& snapshot,
       const RayScene& r)
      : tree(t), rays(r), sources(t, placement, links, snapshot) {}

  std::vector<Place> PlacesOf(const Run& run, std::span<const NodeId> elements,
                              std::span<const uint8_t> corners, int64_t* sums) const {
    std::vector<Place> places;
    for (size_t e = run.begin; e < run.end; ++e) {
      const ConvexPolygon polygon = ShapeBelow(tree, run.leaf, elements[e]);
      const Vec3 centre = polygon.Centroid();
      const double share =
          std::max(kInside, InsideShare(polygon, centre, rays.coordinate_noise_m()));
      for (int k = 0; k < polygon.count; ++k) {
        if (!corners.empty() && (corners[e] >> k & 1) == 0) continue;
        places.push_back({polygon.v[k] + share * (centre - polygon.v[k]),
                          Hash(elements[e].path, elements[e].surface, static_cast<uint64_t>(k)),
                          sums + 12 * e + 3 * k});
      }
    }
    return places;
  }

  const Tree& tree;
  const RayScene& rays;
  SourceFinder sources;
};

Gatherer::Gatherer(const Tree& tree, const Placement& placement, const LinkSet& links,
                   const Snapshot& snapshot, const RayScene& rays)
    : impl_(std::make_unique<Impl>(tree, placement, links, snapshot, rays)) {}
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
  const double largest = impl_->sources.largest_radiosity();
  if (!(largest > 0)) return part;
  part.exponent = 49 - std::ilogb(largest);
  const double scale = std::ldexp(1.0, part.exponent);
  ASSIGN_OR_RETURN(const std::vector<Run> runs, RunsOf(impl_->tree, elements));
  std::atomic<uint64_t> traced{0};
  pool.For(runs.size(), 4, [&](size_t begin, size_t end, int) {
    for (size_t r = begin; r < end; ++r) {
      const std::vector<Place> places =
          impl_->PlacesOf(runs[r], elements, corners, part.sums.data());
      if (places.empty()) continue;
      const LeafSources found = impl_->sources.Find(runs[r].leaf, options, scale);
      LeafGather gather(impl_->tree, impl_->rays, impl_->sources, runs[r].leaf, found, scale);
      for (size_t i = 0; i < places.size(); i += 4) {
        gather.Evaluate(std::span(places).subspan(i, std::min<size_t>(4, places.size() - i)));
      }
      traced += gather.traced();
    }
  });
  part.rays = traced;
  return part;
}

}  // namespace isolux
