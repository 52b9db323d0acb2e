#include "worker/radiosity/gather_sources.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/hierarchy/element.h"
#include "common/util/random.h"
#include "worker/radiosity/cluster_pair.h"
#include "worker/radiosity/glazed_links.h"

namespace isolux {
namespace {

// A source is opened where it brings much and varies by more than this share of itself.
constexpr double kOpenSpread = 0.1;
constexpr int kOpenLevels = 6;
// Or where it is so long that a medium leaves shares of its light that differ by so much.
constexpr double kOpenOpticalSize = 0.25;
// Visibility and radiosity of a source count as varying together from these shares on.
constexpr double kVaryingDoubt = 0.3, kVaryingSpread = 0.2;
// Of the share that is opened: what brings less is not looked at closely.
constexpr double kVaryingShare = 0.1;
// Such a source counts as so many times what it brings when it asks for a ray.
constexpr double kVaryingCare = 4;
// A source in any doubt that brings this share of a leaf's irradiance gets a ray at each point:
// where links are wrong about a place, as beside furniture, they are so together.
constexpr double kRayShare = 0.02;
// Of the mean irradiance: no shares are taken of less.
constexpr double kDarkestShare = 1e-3;
// What eight rays do not see may still be there: hidden sources count with this share.
constexpr double kHiddenShare = 0.1;
// Where links in doubt may bring this many times what is known of a leaf's light, as behind a
// pinhole, sources that unhidden would bring more than this share of it are clipped at what hides
// them, however little all of that is in the scene.
constexpr double kDark = 400, kExactShare = 0.02;
// Irradiance below this share of the mean is dark: shares are taken of that then.
constexpr double kLeastShare = 0.25;

}  // namespace

SourceFinder::SourceFinder(const Tree& tree, const Placement& placement, const LinkSet& links,
                           const Snapshot& snapshot, const RefineScene& between)
    : tree_(tree),
      between_(between),
      medium_(between.medium),
      snapshot_(snapshot),
      slots_(tree),
      inverse_unit_m_(std::ldexp(1.0, -std::ilogb(tree.hierarchy().extent_m()))) {
  PullRadiosity(snapshot);
  PullIrradiance(snapshot);
  ListEnds(placement, links);
}

void SourceFinder::PullRadiosity(const Snapshot& snapshot) {
  radiosity_.assign(slots_.count(tree_), Lanes{});
  const std::vector<PassedLight> passed = tree_.PassedLightOf(snapshot);
  for (size_t k = 0; k < snapshot.leaves.size(); ++k) {
    const LeafRecord& leaf = snapshot.leaves[k];
    const uint32_t node = tree_.Find(leaf.id);
    const Optics optics =
        tree_.hierarchy().maps().Over(tree_.surface_of(node), tree_.polygon(node));
    Lanes& b = radiosity_[slots_.OfElement(node)];
    for (int c = 0; c < 3; ++c) {
      b[c] = optics.exitance[c] + optics.reflectance[c] * leaf.irradiance[c];
      if (!passed.empty()) b[c] += passed[k].radiosity[c];
      largest_ = std::max(largest_, b[c]);
    }
  }
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

void SourceFinder::PullIrradiance(const Snapshot& snapshot) {
  irradiance_.assign(tree_.size(), 0);
  double lit_area = 0, arriving = 0;
  for (const LeafRecord& leaf : snapshot.leaves) {
    const uint32_t node = tree_.Find(leaf.id);
    const double sum = leaf.irradiance[0] + leaf.irradiance[1] + leaf.irradiance[2];
    irradiance_[node] = static_cast<float>(sum);
    if (!(sum > 0)) continue;
    lit_area += tree_.area_m2(node);
    arriving += tree_.area_m2(node) * sum;
  }
  least_irradiance_ = std::max(kLeastShare * arriving / std::max(lit_area, 1e-300), 1e-300);
  for (auto node = static_cast<uint32_t>(tree_.size()); node-- > 0;) {
    const uint32_t child = tree_.node(node).first_child;
    if (tree_.is_cluster(node) || child == kNoNode) continue;
    irradiance_[node] = static_cast<float>((tree_.area_m2(child) * irradiance_[child] +
                                            tree_.area_m2(child + 1) * irradiance_[child + 1]) /
                                           (tree_.area_m2(child) + tree_.area_m2(child + 1)));
  }
}

void SourceFinder::ListEnds(const Placement& placement, const LinkSet& links) {
  std::vector<const Link*> mine;
  for (const Link& link : links.own) mine.push_back(&link);
  for (const Link& link : links.crown) {
    if (placement.HomeOfLink(link.p, link.q) == placement.self()) mine.push_back(&link);
  }
  std::erase_if(mine, [](const Link* link) { return link->unoccluded_m2 <= 0; });
  for (const Link* link : mine) {
    if (between_.panes == nullptr) break;
    if (tree_.is_cluster(link->p) || tree_.is_cluster(link->q)) {
      left_of_clusters_.emplace(link, LeftByPanes(between_, tree_, *link));
    }
  }
  first_.assign(tree_.size() + 1, 0);
  for (const Link* link : mine) {
    ++first_[link->p + 1];
    if (link->p != link->q) ++first_[link->q + 1];
  }
  for (size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  ends_.resize(2 * mine.size());
  std::vector<uint64_t> next(first_.begin(), first_.end() - 1);
  for (const Link* link : mine) {
    ends_[next[link->p]++] = {link, false};
    if (link->p != link->q) ends_[next[link->q]++] = {link, true};
  }
}

void SourceFinder::Fill(uint32_t node, const SurfaceFrame& frame, const GatherOptions& options,
                        double scale, SourceBlock& block) const {
  const Filling filling{node,
                        // What is small against the scene's light counts as even.
                        std::max<double>(irradiance_[node], least_irradiance_),
                        tree_.polygon(node).Centroid(), frame.n, scale, options, block};
  block.Start(frame, filling.centre, inverse_unit_m_);
  const auto add = [&](uint32_t at) {
    for (uint64_t i = first_[at]; i < first_[at + 1]; ++i) AddEnd(filling, at, ends_[i]);
  };
  add(node);
  if (!tree_.node(node).id.is_surface()) return;
  for (uint32_t above = tree_.node(node).parent; above != kNoNode;
       above = tree_.node(above).parent) {
    // Clusters that do not stand for the surface bring it nothing, nor do those above them.
    if (!tree_.facing().StandsFor(above, tree_.node(node).id.surface)) break;
    add(above);
  }
}

GatherCare SourceFinder::CareAt(uint32_t leaf, const GatherOptions& options) const {
  const double known = irradiance_[leaf];
  const double doubt = snapshot_.leaves[tree_.first_leaf(leaf)].doubt;
  const double local = std::max(known, kDarkestShare / kLeastShare * least_irradiance_);
  GatherCare care;
  if (doubt > 0) {
    care.rays_per_doubt_w_m2 = std::min(options.most_rays / doubt, 1 / (options.ray_share * local));
  }
  care.ray_from_w_m2 = std::min(kRayShare, 10 * options.ray_share) * local;
  if (doubt > kDark * known) care.exact_from_w_m2 = kExactShare * known;
  care.tolerance_w_m2 = options.point_error * local;
  return care;
}

double SourceFinder::RelativeRadiosityAt(uint32_t node, const Vec3& point) const {
  const auto sum = [&](uint32_t element) {
    const Lanes& b = radiosity_[slots_.OfElement(element)];
    return b[0] + b[1] + b[2];
  };
  const double whole = sum(node);
  if (!(whole > 0)) return 1;
  const Vec3 n = tree_.normal(node);
  while (tree_.node(node).first_child != kNoNode) {
    const uint32_t child = tree_.node(node).first_child;
    // The cut runs between the second and third corner of the first part (element.h).
    const ConvexPolygon& first = tree_.polygon(child);
    const Vec3 cut = first.v[2] - first.v[1];
    node = glm::dot(glm::cross(n, cut), point - first.v[1]) >= 0 ? child : child + 1;
  }
  return sum(node) / whole;
}

// Of an element, from the middle of the receiver.
double SourceFinder::FactorAtCentre(const Filling& filling, uint32_t other,
                                    const MirrorImage* image) const {
  const Vec3 centre = tree_.centre(other), towards = tree_.normal(other);
  const Vec3 d = (image == nullptr ? centre : image->image.Point(centre)) - filling.centre;
  const Vec3 normal = image == nullptr ? towards : image->image.Direction(towards);
  const double d2 = glm::dot(d, d);
  if (!(d2 > 0)) return 0;
  const double cosines =
      std::max(0.0, glm::dot(filling.normal, d)) * std::max(0.0, -glm::dot(normal, d));
  return std::min(1.0, cosines * tree_.area_m2(other) / (std::numbers::pi * d2 * d2));
}

Lanes SourceFinder::LeftAtCentre(const Filling& filling, uint32_t other,
                                 const MirrorImage* image) const {
  const Vec3 centre = tree_.centre(other);
  const Rgb left = medium_->Along(
      glm::length((image == nullptr ? centre : image->image.Point(centre)) - filling.centre));
  return Lanes{left.x, left.y, left.z, 0};
}

Lanes SourceFinder::LeftByPanesOf(const Link& link) const {
  const auto known = left_of_clusters_.find(&link);
  const Rgb left =
      known != left_of_clusters_.end() ? known->second : LeftByPanes(between_, tree_, link);
  return Lanes{left.x, left.y, left.z, 1};
}

Glazed SourceFinder::GlazedOf(const Link& link) const {
  Glazed glazed;
  if (between_.panes == nullptr) return glazed;
  const Crossing crossing = PanesBetween(*between_.panes, tree_, link);
  if (crossing == Crossing::kNone) return glazed;
  const bool whole = !between_.occlusion || link.rays() == Link::kProved;
  glazed.kind = crossing == Crossing::kAll || whole ? Glazed::Kind::kByPoint : Glazed::Kind::kMean;
  if (glazed.kind == Glazed::Kind::kByPoint) return glazed;
  const Lanes left = LeftByPanesOf(link);
  for (int c = 0; c < 3; ++c) glazed.mean[c] = static_cast<float>(left[c]);
  return glazed;
}

bool SourceFinder::VariesByMedium(const Part& part) const {
  if (medium_ == nullptr) return false;
  const ConvexPolygon& shape = part.shape.count > 0 ? part.shape : tree_.polygon(part.node);
  return medium_->largest_per_m() * SizeOf(shape) > kOpenOpticalSize;
}

bool SourceFinder::IsCutByPanes(const Filling& filling, Part* part) const {
  if (part->glazed.kind != Glazed::Kind::kByPoint || part->image != nullptr) return false;
  const auto corners = [](const ConvexPolygon& polygon) {
    return std::span(polygon.v.data(), static_cast<size_t>(polygon.count));
  };
  const Crossing crossing = between_.panes->Between(
      corners(tree_.polygon(filling.receiver)),
      corners(part->shape.count > 0 ? part->shape : tree_.polygon(part->node)));
  if (crossing == Crossing::kNone) part->glazed = {};
  part->glazed.all = crossing == Crossing::kAll;
  return crossing == Crossing::kSome;
}

// Where a medium or panes make parts of a leaf differ.
void SourceFinder::OpenLeaf(const Filling& filling, const Part& part) const {
  const ConvexPolygon& shape = part.shape.count > 0 ? part.shape : tree_.polygon(part.node);
  uint64_t number = 0;
  for (const ConvexPolygon& half_shape : Subdivide(shape)) {
    Part half = part;
    half.shape = half_shape;
    half.factor = part.factor * half_shape.Area() / shape.Area();
    half.seed = Hash(part.seed, ++number);
    ++half.level;
    Open(filling, half);
  }
}

// Of the link's other end, what is seen from this one.
const MirrorImage* SourceFinder::ImageAt(const End& end) const {
  if (!end.link->through_mirrors()) return nullptr;
  const MirrorImage& of_q = tree_.mirrors()->images()[end.link->image()];
  return end.at_q ? &tree_.mirrors()->images()[of_q.reverse] : &of_q;
}

void SourceFinder::AddClusterEnd(const Filling& filling, const End& end) const {
  const Link& link = *end.link;
  const uint32_t other = end.other();
  const Slots::Ends slots = slots_.Of(tree_, link);
  const uint32_t slot = end.at_q ? slots.p : slots.q;
  const MirrorImage* image = ImageAt(end);
  const Vec3 centre =
      image == nullptr ? tree_.centre(other) : image->image.Point(tree_.centre(other));
  if (glm::dot(filling.normal, centre - filling.centre) <= 0) return;
  filling.block.AddCluster(centre, tree_.facing().area_m2(other, slots_.DirectionOf(slot)),
                           link.visibility() * (image == nullptr ? 1.0 : image->share),
                           between_.panes == nullptr
                               ? filling.scale * radiosity_[slot]
                               : filling.scale * radiosity_[slot] * LeftByPanesOf(link));
}

void SourceFinder::AddEnd(const Filling& filling, uint32_t node, const End& end) const {
  const Link& link = *end.link;
  const uint32_t other = end.other();
  if (tree_.is_cluster(other)) return AddClusterEnd(filling, end);
  const double visibility = link.visibility();
  const MirrorImage* image = ImageAt(end);
  const double mean_factor =
      tree_.is_cluster(node)
          ? FactorAtCentre(filling, other, image) * (image == nullptr ? 1.0 : image->share)
          : end.share() * link.unoccluded_m2 / tree_.area_m2(node);
  const double seen = std::max(visibility, kHiddenShare) * mean_factor;
  if (seen * tree_.values(other).radiosity < filling.options.even_share * filling.arriving) {
    Lanes arriving = mean_factor * visibility * filling.scale * radiosity_[slots_.OfElement(other)];
    if (medium_ != nullptr) arriving *= LeftAtCentre(filling, other, image);
    if (between_.panes != nullptr) arriving *= LeftByPanesOf(link);
    filling.block.AddEven(arriving);
    return;
  }
  const NodeId& a = tree_.node(link.p).id;
  const NodeId& b = tree_.node(link.q).id;
  uint64_t seed = Hash(filling.options.seed, Hash(a.surface, a.path), Hash(b.surface, b.path));
  if (image != nullptr) seed = Hash(seed, link.image());
  Open(filling, {other, seen, 0, visibility, link.doubt(), seed, image, GlazedOf(link)});
}

// Adds the source, or its children where it brings much and varies.
void SourceFinder::Open(const Filling& filling, const Part& whole_part) const {
  Part part = whole_part;
  const bool cut_by_panes = IsCutByPanes(filling, &part);
  const NodeValues& values = tree_.values(part.node);
  const uint32_t child = tree_.node(part.node).first_child;
  const double brings = part.factor * values.radiosity;
  const double open_from = filling.options.open_share * filling.arriving;
  const bool opens = part.level < kOpenLevels && brings > open_from;
  const bool absorbed = opens && (cut_by_panes || VariesByMedium(part));
  if (absorbed && child == kNoNode) return OpenLeaf(filling, part);
  if (child != kNoNode && opens && (values.spread > kOpenSpread * values.radiosity || absorbed)) {
    for (uint32_t i = child; i < child + 2; ++i) {
      Part half = part;
      half.node = i;
      half.factor = part.factor * tree_.area_m2(i) / tree_.area_m2(part.node);
      ++half.level;
      Open(filling, half);
    }
    return;
  }
  const MirrorImage* image = part.image;
  const ConvexPolygon& whole = part.shape.count > 0 ? part.shape : tree_.polygon(part.node);
  const ClippedPolygon polygon =
      ClipToFront(image == nullptr ? whole : image->image.Of(whole), filling.centre, filling.normal,
                  1e-12 * tree_.hierarchy().extent_m());
  if (polygon.count == 0) return;
  const bool varies = child != kNoNode && part.doubt > kVaryingDoubt &&
                      values.spread > kVaryingSpread * values.radiosity &&
                      brings > kVaryingShare * open_from;
  SourceBlock::Strength strength;
  strength.radiosity = filling.scale * radiosity_[slots_.OfElement(part.node)];
  strength.visibility = part.visibility;
  strength.doubt = part.doubt * values.radiosity;
  if (part.doubt > 0) strength.brings = (varies ? kVaryingCare : 1) * values.radiosity;
  if (part.doubt > 0 && !varies && image == nullptr && part.glazed.kind == Glazed::Kind::kNot) {
    strength.exact_per_w_m2 = 1 / values.radiosity;
  }
  strength.seed = Hash(part.seed, tree_.node(part.node).id.path);
  RayTarget target;
  target.normal = tree_.normal(part.node);
  if (image != nullptr) {
    target.image = image;
    target.normal = image->image.Direction(target.normal);
    strength.radiosity = image->share * strength.radiosity;
    strength.doubt *= image->share;
    strength.brings *= image->share;
  }
  target.surface_polygon = tree_.surface_of(part.node).polygon;
  target.seed = strength.seed;
  if (varies) target.varying = part.node;
  target.glazed = part.glazed;
  filling.block.Add(polygon, target.normal, strength, target);
}

}  // namespace isolux
