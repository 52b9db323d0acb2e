#include "worker/radiosity/gather.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numbers>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/point_factor.h"
#include "worker/radiosity/visibility.h"

namespace isolux {
namespace {

// A source is opened where it brings much and varies by more than this share of itself.
constexpr double kOpenSpread = 0.1;
// What eight rays do not see may still be there: hidden sources count with this share.
constexpr double kHiddenShare = 0.1;
constexpr int kOpenLevels = 6;
// Of eight rays, from one source to the corners of one element.
constexpr double kMostPackets = 64;
// Irradiance below this share of the mean is dark: shares are taken of that then.
constexpr double kLeastShare = 0.25;
// Links whose eight rays agree are right but for a few: they get this share of the rays that their
// variance would ask for. Otherwise the dark backs of furniture take most of all rays.
constexpr double kUnanimous = 0.3;
// Points lie so far inside their element, so that none is on an edge or in a contact.
constexpr double kInside = 1e-5;

// All links by the node they end at: those of node n are ends_[first_[n] .. first_[n+1]).
class LinksOfNodes {
 public:
  LinksOfNodes(const Tree& tree, const Placement& placement, const LinkSet& links)
      : first_(tree.size() + 1, 0) {
    std::vector<const Link*> mine;
    for (const Link& link : links.own) mine.push_back(&link);
    for (const Link& link : links.crown) {
      if (placement.HomeOfLink(link.p, link.q) == placement.self()) mine.push_back(&link);
    }
    std::erase_if(mine, [](const Link* link) { return link->unoccluded_m2 <= 0; });
    for (const Link* link : mine) {
      ++first_[link->p + 1];
      ++first_[link->q + 1];
    }
    for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    ends_.resize(2 * mine.size());
    std::vector<uint64_t> next(first_.begin(), first_.end() - 1);
    for (const Link* link : mine) {
      ends_[next[link->p]++] = {link, false};
      ends_[next[link->q]++] = {link, true};
    }
  }

  struct End {
    const Link* link;
    bool at_q;
    uint32_t other() const { return at_q ? link->p : link->q; }
  };
  std::span<const End> Of(uint32_t node) const {
    return std::span(ends_).subspan(first_[node], first_[node + 1] - first_[node]);
  }

 private:
  std::vector<uint64_t> first_;
  std::vector<End> ends_;
};

// What a leaf receives from: an element of one of its sources, ready for evaluation.
struct Source {
  ClippedPolygon polygon;  // in front of the leaf's plane; count 0 where F does not vary
  Lanes radiosity{};       // by channel
  Vec3 normal{0.0}, point{0.0};
  uint32_t surface_polygon = 0;
  double visibility = 1;
  double form_factor = 0;  // of a source without a polygon: the same at every point
  double packets = 0;      // of rays wanted at an element's corners, on average
  uint64_t seed = 0;
};

class Gatherer {
 public:
  Gatherer(const Tree& tree, const Placement& placement, const LinkSet& links,
           const Snapshot& snapshot, const RayScene& rays, const GatherOptions& options)
      : tree_(tree),
        snapshot_(snapshot),
        rays_(rays),
        options_(options),
        links_(tree, placement, links) {
    PullRadiosity();
  }

  double largest_radiosity() const { return largest_; }

  // Adds to 12 integers an element: 4 corners × 3 channels.
  uint64_t GatherLeaf(uint32_t leaf, std::span<const NodeId> elements, double scale,
                      int64_t* sums) const {
    const std::vector<Source> sources = SourcesOf(leaf);
    if (sources.empty()) return 0;
    uint64_t traced = 0;
    for (size_t e = 0; e < elements.size(); ++e) {
      traced += GatherElement(leaf, elements[e], sources, scale, sums + 12 * e);
    }
    return traced;
  }

 private:
  void PullRadiosity() {
    radiosity_.assign(tree_.size(), Lanes{});
    double lit_area = 0, arriving = 0;
    for (const LeafRecord& leaf : snapshot_.leaves) {
      const Surface& surface = tree_.hierarchy().surfaces()[leaf.id.surface];
      const uint32_t node = tree_.Find(leaf.id);
      Lanes& b = radiosity_[node];
      const double sum = leaf.irradiance[0] + leaf.irradiance[1] + leaf.irradiance[2];
      if (sum > 0) {
        lit_area += tree_.area_m2(node);
        arriving += tree_.area_m2(node) * sum;
      }
      for (int c = 0; c < 3; ++c) {
        b[c] = surface.exitance[c] + surface.reflectance[c] * leaf.irradiance[c];
        largest_ = std::max(largest_, b[c]);
      }
    }
    least_irradiance_ = std::max(kLeastShare * arriving / std::max(lit_area, 1e-300), 1e-300);
    for (size_t i = tree_.size(); i-- > 0;) {
      Lanes sum{};
      double area = 0;
      tree_.ForEachChild(static_cast<uint32_t>(i), [&](uint32_t child) {
        if (tree_.is_cluster(static_cast<uint32_t>(i))) return;
        sum += tree_.area_m2(child) * radiosity_[child];
        area += tree_.area_m2(child);
      });
      if (area > 0) radiosity_[i] = sum / area;
    }
    for (size_t i = tree_.hierarchy().clusters().size(); i-- > 0;) {
      Lanes sum{};
      tree_.ForEachChild(static_cast<uint32_t>(i),
                         [&](uint32_t child) { sum += tree_.area_m2(child) * radiosity_[child]; });
      if (tree_.area_m2(i) > 0) radiosity_[i] = sum / tree_.area_m2(i);
    }
  }

  std::vector<Source> SourcesOf(uint32_t leaf) const {
    std::vector<Source> sources;
    const LeafRecord& record = snapshot_.leaves[tree_.first_leaf(leaf)];
    // What is small against the scene's light needs no rays for its own sake.
    const double arriving = std::max(
        record.irradiance[0] + record.irradiance[1] + record.irradiance[2], least_irradiance_);
    for (uint32_t node = leaf; node != kNoNode; node = tree_.node(node).parent) {
      for (const LinksOfNodes::End& end : links_.Of(node))
        AddSources(leaf, node, end, arriving, sources);
    }
    return sources;
  }

  void AddSources(uint32_t leaf, uint32_t node, const LinksOfNodes::End& end, double arriving,
                  std::vector<Source>& sources) const {
    const Link& link = *end.link;
    const uint32_t other = end.other();
    Source source;
    source.visibility = link.visibility();
    const NodeId& a = tree_.node(link.p).id;
    const NodeId& b = tree_.node(link.q).id;
    source.seed = Hash(options_.seed, Hash(a.surface, a.path), Hash(b.surface, b.path));
    const double seen = std::max(source.visibility, kHiddenShare);
    const double share = seen * link.unoccluded_m2 / tree_.area_m2(node) / arriving;
    if (tree_.is_cluster(node) || tree_.is_cluster(other) ||
        share * tree_.values(other).radiosity < options_.even_share) {
      source.form_factor = link.unoccluded_m2 / tree_.area_m2(node);
      source.radiosity = radiosity_[other];
      sources.push_back(source);
      return;
    }
    // Rays for what is in doubt: by the variance of one ray, over the share that is seen.
    const double deviation = link.visibility_deviation();
    const bool unanimous = link.visible_rays == 0 || link.visible_rays == Link::kRays;
    const double doubt = 2 * deviation * deviation * (unanimous ? kUnanimous : 1.0) / seen;
    Open(leaf, other, share, doubt, source, 0, sources);
  }

  // Adds the source, or its children where it brings much and varies.
  void Open(uint32_t leaf, uint32_t other, double share_per_radiosity, double doubt,
            const Source& from, int level, std::vector<Source>& sources) const {
    const NodeValues& values = tree_.values(other);
    const double share = share_per_radiosity * values.radiosity;
    const uint32_t child = tree_.node(other).first_child;
    if (child != kNoNode && level < kOpenLevels && share > options_.open_share &&
        values.spread > kOpenSpread * values.radiosity) {
      for (uint32_t i = 0; i < 2; ++i) {
        const double part = tree_.area_m2(child + i) / tree_.area_m2(other);
        Open(leaf, child + i, share_per_radiosity * part, doubt, from, level + 1, sources);
      }
      return;
    }
    Source source = from;
    const ConvexPolygon& polygon = tree_.polygon(leaf);
    source.polygon = ClipToFront(tree_.polygon(other), polygon.v[0], tree_.normal(leaf),
                                 1e-12 * tree_.hierarchy().extent_m());
    if (source.polygon.count == 0) return;
    source.radiosity = radiosity_[other];
    source.normal = tree_.normal(other);
    source.point = tree_.polygon(other).v[0];
    source.surface_polygon = tree_.surface_of(other).polygon;
    source.packets = 0.5 * options_.rays * share * doubt;
    source.seed = Hash(from.seed, tree_.node(other).id.path);
    sources.push_back(source);
  }

  uint64_t GatherElement(uint32_t leaf, const NodeId& element, const std::vector<Source>& sources,
                         double scale, int64_t* sums) const {
    ConvexPolygon polygon = tree_.polygon(leaf);
    for (int level = element.level() - tree_.node(leaf).id.level() - 1; level >= 0; --level) {
      polygon = Subdivide(polygon)[(element.path >> level) & 1];
    }
    const Vec3 centre = polygon.Centroid();
    std::array<Vec3, 4> corner;
    for (int i = 0; i < 4; ++i) {
      corner[i] = i < polygon.count ? polygon.v[i] + kInside * (centre - polygon.v[i]) : centre;
    }
    const Vec3x4 points(corner);
    const Vec3 normal = tree_.normal(leaf);
    uint64_t traced = 0;
    std::array<IntLanes, 3> total{};
    for (const Source& source : sources) {
      Lanes factor = Splat(source.form_factor);
      Lanes visibility = Splat(source.visibility);
      if (source.polygon.count > 0) {
        const Lanes height = Dot(source.normal, points - source.point);
        factor = PointFormFactors(points, normal,
                                  {source.polygon.v.data(), size_t(source.polygon.count)});
        factor = Select(height > 0.0, factor, Splat(0.0));
        traced += SampleAtCorners(leaf, element, source, corner, polygon.count, visibility);
      }
      const Lanes arriving = factor * visibility * scale;
      for (int c = 0; c < 3; ++c) total[c] += ToInteger(arriving * source.radiosity[c]);
    }
    for (int i = 0; i < polygon.count; ++i) {
      for (int c = 0; c < 3; ++c) sums[3 * i + c] = total[c][i];
    }
    return traced;
  }

  // Replaces the link's visibility by that of rays from each corner, where its share calls for
  // some: a packet is two rays a corner.
  uint64_t SampleAtCorners(uint32_t leaf, const NodeId& element, const Source& source,
                           const std::array<Vec3, 4>& corner, int corners,
                           Lanes& visibility) const {
    if (!(source.packets > 0)) return 0;
    Random random(Hash(source.seed, element.path, element.surface));
    const int packets = static_cast<int>(std::min(kMostPackets, source.packets + random.Unit()));
    if (packets == 0) return 0;
    ConvexPolygon target;
    target.count = std::min(source.polygon.count, 4);
    std::copy_n(source.polygon.v.begin(), target.count, target.v.begin());
    const uint32_t own = tree_.surface_of(leaf).polygon;
    std::array<double, 4> passed{}, total{};
    for (int k = 0; k < packets; ++k) {
      std::array<Segment, 8> segments;
      std::array<double, 8> weight;
      const double u = random.Unit(), v = random.Unit();
      for (int i = 0; i < 2 * corners; ++i) {
        // The same two points for all corners, opposite in the source: less noise between corners.
        const double s = u + 0.5 * (i >= corners ? 1 : 0);
        const double t = v + 0.5 * (i >= corners ? 1 : 0);
        const Vec3 to = SamplePolygon(target, s - std::floor(s), t - std::floor(t));
        const Vec3& from = corner[i % corners];
        const Vec3 d = to - from;
        const double d2 = glm::dot(d, d);
        weight[i] = std::max(0.0, glm::dot(tree_.normal(leaf), d)) *
                    std::max(0.0, -glm::dot(source.normal, d)) / (d2 * d2);
        segments[i] = {from, to, own, source.surface_polygon};
      }
      const uint32_t visible = rays_.Visible(segments, 2 * corners);
      for (int i = 0; i < 2 * corners; ++i) {
        total[i % corners] += weight[i];
        if ((visible >> i & 1) != 0) passed[i % corners] += weight[i];
      }
    }
    for (int i = 0; i < corners; ++i) {
      if (total[i] > 0) visibility[i] = passed[i] / total[i];
    }
    return static_cast<uint64_t>(packets) * 2 * corners;
  }

  const Tree& tree_;
  const Snapshot& snapshot_;
  const RayScene& rays_;
  const GatherOptions& options_;
  LinksOfNodes links_;
  std::vector<Lanes> radiosity_;  // by node
  double largest_ = 0;
  double least_irradiance_ = 0;  // W/m², over the channels, below which a leaf counts as dark
};

}  // namespace

Result<GatherPart> GatherAtCorners(const std::vector<NodeId>& elements, const Tree& tree,
                                   const Placement& placement, const LinkSet& links,
                                   const Snapshot& snapshot, const RayScene& rays,
                                   const GatherOptions& options, ThreadPool& pool) {
  const Gatherer gatherer(tree, placement, links, snapshot, rays, options);
  GatherPart part;
  part.sums.assign(12 * elements.size(), 0);
  if (!(gatherer.largest_radiosity() > 0)) return part;
  part.exponent = 49 - std::ilogb(gatherer.largest_radiosity());
  const double scale = std::ldexp(1.0, part.exponent);

  // Runs of elements below one leaf.
  struct Run {
    uint32_t leaf;
    size_t begin, end;
  };
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
  std::atomic<uint64_t> traced{0};
  pool.For(runs.size(), 4, [&](size_t begin, size_t end, int) {
    uint64_t rays_here = 0;
    for (size_t r = begin; r < end; ++r) {
      const Run& run = runs[r];
      rays_here +=
          gatherer.GatherLeaf(run.leaf, std::span(elements).subspan(run.begin, run.end - run.begin),
                              scale, part.sums.data() + 12 * run.begin);
    }
    traced += rays_here;
  });
  part.rays = traced;
  return part;
}

}  // namespace isolux
