#include "worker/radiosity/gather_sources.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/random.h"
#include "worker/coupling/point_factor.h"

namespace isolux {
namespace {

// A source is opened where it brings much and varies by more than this share of itself.
constexpr double kOpenSpread = 0.1;
constexpr int kOpenLevels = 6;
// Visibility and radiosity of a source count as varying together from these shares on.
constexpr double kVaryingDoubt = 0.3, kVaryingSpread = 0.2;
// Of the share that is opened: what brings less is not looked at closely.
constexpr double kVaryingShare = 0.1;
// What eight rays do not see may still be there: hidden sources count with this share.
constexpr double kHiddenShare = 0.1;
// Irradiance below this share of the mean is dark: shares are taken of that then.
constexpr double kLeastShare = 0.25;

}  // namespace

Lanes ClusterFactors(const Vec3x4& points, const Vec3& n, const Vec3& centre, double facing_m2) {
  const Vec3x4 d = centre - points;
  const Lanes distance2 = Dot(d, d);
  const Lanes cosine = Maximum(Dot(n, d), Splat(0.0)) / SquareRoot(distance2 + 1e-300);
  // A/(π d² + A), a disk's form factor seen face on, about; at most 1.
  return cosine * facing_m2 / (std::numbers::pi * distance2 + facing_m2 + 1e-300);
}

SourceFinder::SourceFinder(const Tree& tree, const Placement& placement, const LinkSet& links,
                           const Snapshot& snapshot)
    : tree_(tree), snapshot_(snapshot), slots_(tree) {
  PullRadiosity(snapshot);
  ListEnds(placement, links);
}

void SourceFinder::PullRadiosity(const Snapshot& snapshot) {
  radiosity_.assign(slots_.count(tree_), Lanes{});
  double lit_area = 0, arriving = 0;
  for (const LeafRecord& leaf : snapshot.leaves) {
    const Surface& surface = tree_.hierarchy().surfaces()[leaf.id.surface];
    const uint32_t node = tree_.Find(leaf.id);
    Lanes& b = radiosity_[slots_.OfElement(node)];
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
  for (auto node = static_cast<uint32_t>(tree_.size()); node-- > 0;) {
    if (tree_.is_cluster(node) || tree_.node(node).first_child == kNoNode) continue;
    Lanes sum{};
    double area = 0;
    tree_.ForEachChild(node, [&](uint32_t child) {
      sum += tree_.area_m2(child) * radiosity_[slots_.OfElement(child)];
      area += tree_.area_m2(child);
    });
    if (area > 0) radiosity_[slots_.OfElement(node)] = sum / area;
  }
  const ClusterFacing& facing = tree_.facing();
  for (auto c = static_cast<uint32_t>(tree_.hierarchy().clusters().size()); c-- > 0;) {
    for (int d = 0; d < kDirections; ++d) {
      if (!(facing.area_m2(c, d) > 0)) continue;
      Lanes sum{};
      tree_.ForEachChild(c, [&](uint32_t child) {
        if (tree_.is_cluster(child)) {
          sum += facing.part_m2(c, child, d) * radiosity_[slots_.OfCluster(child, d)];
        } else {
          const double cosine = facing.cosine(tree_.node(child).id.surface, d);
          sum += tree_.area_m2(child) * cosine * radiosity_[slots_.OfElement(child)];
        }
      });
      radiosity_[slots_.OfCluster(c, d)] = sum / facing.area_m2(c, d);
    }
  }
}

void SourceFinder::ListEnds(const Placement& placement, const LinkSet& links) {
  std::vector<const Link*> mine;
  for (const Link& link : links.own) mine.push_back(&link);
  for (const Link& link : links.crown) {
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) mine.push_back(&link);
  }
  std::erase_if(mine, [](const Link* link) { return link->unoccluded_m2 <= 0; });
  first_.assign(tree_.size() + 1, 0);
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

LeafSources SourceFinder::Find(uint32_t leaf, const GatherOptions& options, double scale) const {
  const LeafRecord& record = snapshot_.leaves[tree_.first_leaf(leaf)];
  Receiver receiver;
  receiver.leaf = leaf;
  receiver.centre = tree_.polygon(leaf).Centroid();
  receiver.normal = tree_.normal(leaf);
  // What is small against the scene's light needs no rays for its own sake.
  receiver.arriving = std::max(record.irradiance[0] + record.irradiance[1] + record.irradiance[2],
                               least_irradiance_);
  if (record.doubt > 0) receiver.rays_per_w_m2 = options.rays / static_cast<double>(record.doubt);
  LeafSources found;
  for (uint32_t node = leaf; node != kNoNode; node = tree_.node(node).parent) {
    // Nor do the clusters above one that does not.
    if (tree_.is_cluster(node) && !tree_.facing().StandsFor(node, tree_.node(leaf).id.surface))
      break;
    for (uint64_t i = first_[node]; i < first_[node + 1]; ++i) {
      Add(receiver, node, ends_[i], options, scale, found);
    }
  }
  return found;
}

double SourceFinder::RelativeRadiosityAt(uint32_t node, const Vec3& point) const {
  const auto sum = [&](uint32_t element) {
    const Lanes& b = radiosity_[slots_.OfElement(element)];
    return b[0] + b[1] + b[2];
  };
  const double whole = sum(node);
  const Vec3 n = tree_.normal(node);
  while (tree_.node(node).first_child != kNoNode) {
    const uint32_t child = tree_.node(node).first_child;
    const ConvexPolygon& first = tree_.polygon(child);
    bool inside = true;
    for (int i = 0; i < first.count; ++i) {
      const Vec3 side = first.v[(i + 1) % first.count] - first.v[i];
      inside &= glm::dot(glm::cross(n, side), point - first.v[i]) >= 0;
    }
    node = inside ? child : child + 1;
  }
  return whole > 0 ? sum(node) / whole : 1.0;
}

// Of an element, from the middle of the leaf.
double SourceFinder::FactorAtCentre(const Receiver& receiver, uint32_t other) const {
  const Vec3 d = tree_.centre(other) - receiver.centre;
  const double d2 = glm::dot(d, d);
  if (!(d2 > 0)) return 0;
  const double cosines = std::max(0.0, glm::dot(receiver.normal, d)) *
                         std::max(0.0, -glm::dot(tree_.normal(other), d));
  return std::min(1.0, cosines * tree_.area_m2(other) / (std::numbers::pi * d2 * d2));
}

void SourceFinder::Add(const Receiver& receiver, uint32_t node, const End& end,
                       const GatherOptions& options, double scale, LeafSources& found) const {
  const Link& link = *end.link;
  const uint32_t other = end.other();
  Source source;
  source.visibility = link.visibility();
  const NodeId& a = tree_.node(link.p).id;
  const NodeId& b = tree_.node(link.q).id;
  source.seed = Hash(options.seed, Hash(a.surface, a.path), Hash(b.surface, b.path));
  if (tree_.is_cluster(other)) {
    const Slots::Ends slots = slots_.Of(tree_, link.p, link.q);
    const uint32_t slot = end.at_q ? slots.p : slots.q;
    source.point = tree_.centre(other);
    source.facing_m2 = tree_.facing().area_m2(other, slots_.DirectionOf(slot));
    source.radiosity = radiosity_[slot];
    found.sources.push_back(source);
    return;
  }
  const double mean_factor = tree_.is_cluster(node) ? FactorAtCentre(receiver, other)
                                                    : link.unoccluded_m2 / tree_.area_m2(node);
  const double seen = std::max(source.visibility, kHiddenShare);
  if (seen * mean_factor * tree_.values(other).radiosity < options.even_share * receiver.arriving) {
    const double factor = mean_factor * source.visibility * scale;
    for (int c = 0; c < 3; ++c) {
      found.even[c] += static_cast<int64_t>(radiosity_[slots_.OfElement(other)][c] * factor);
    }
    return;
  }
  source.doubt = link.doubt();
  source.rays = receiver.rays_per_w_m2 * source.doubt * tree_.values(other).radiosity;
  Open(receiver, other, seen * mean_factor, source, 0, options, found.sources);
}

// Adds the source, or its children where it brings much and varies.
void SourceFinder::Open(const Receiver& receiver, uint32_t other, double factor, const Source& from,
                        int level, const GatherOptions& options,
                        std::vector<Source>& sources) const {
  const NodeValues& values = tree_.values(other);
  const uint32_t child = tree_.node(other).first_child;
  if (child != kNoNode && level < kOpenLevels &&
      factor * values.radiosity > options.open_share * receiver.arriving &&
      values.spread > kOpenSpread * values.radiosity) {
    for (uint32_t i = 0; i < 2; ++i) {
      const double part = tree_.area_m2(child + i) / tree_.area_m2(other);
      Open(receiver, child + i, factor * part, from, level + 1, options, sources);
    }
    return;
  }
  Source source = from;
  const ConvexPolygon& polygon = tree_.polygon(receiver.leaf);
  source.polygon = ClipToFront(tree_.polygon(other), polygon.v[0], receiver.normal,
                               1e-12 * tree_.hierarchy().extent_m());
  if (source.polygon.count == 0) return;
  source.radiosity = radiosity_[slots_.OfElement(other)];
  source.normal = tree_.normal(other);
  source.point = tree_.polygon(other).v[0];
  source.surface_polygon = tree_.surface_of(other).polygon;
  if (child != kNoNode && from.doubt > kVaryingDoubt &&
      values.spread > kVaryingSpread * values.radiosity &&
      factor * values.radiosity > kVaryingShare * options.open_share * receiver.arriving) {
    source.varying = other;
  }
  source.seed = Hash(from.seed, tree_.node(other).id.path);
  sources.push_back(source);
}

}  // namespace isolux
