#include "common/hierarchy/mirrors.h"

#include <algorithm>
#include <map>
#include <numbers>

namespace isolux {
namespace {

// Of the accuracy: images that bring no more than this share of the light on the mirrors are left
// out.
constexpr double kLeastShare = 1e-2;

Isometry Reflection(const Vec3& normal, double height_m) {
  return {glm::dmat3(1.0) - 2.0 * glm::outerProduct(normal, normal), 2 * height_m * normal, true};
}

std::vector<uint32_t> NumbersOf(const MirrorImage& image) {
  std::vector<uint32_t> numbers;
  for (const MirrorOpening& opening : image.openings) numbers.push_back(opening.plane);
  return numbers;
}

}  // namespace

ConvexPolygon Isometry::Of(const ConvexPolygon& polygon) const {
  ConvexPolygon result;
  result.count = polygon.count;
  for (int i = 0; i < polygon.count; ++i) {
    result.v[i] = Point(polygon.v[reverses ? polygon.count - 1 - i : i]);
  }
  return result;
}

Isometry Isometry::Inverse() const {
  const glm::dmat3 turned = glm::transpose(turn);
  return {turned, -(turned * shift), reverses};
}

Isometry operator*(const Isometry& last, const Isometry& first) {
  return {last.turn * first.turn, last.turn * first.shift + last.shift,
          last.reverses != first.reverses};
}

std::vector<MirrorPlane> MirrorPlanesOf(const Hierarchy& hierarchy) {
  std::vector<MirrorPlane> planes;
  // By plane, which way it faces and what it reflects.
  std::map<std::pair<uint32_t, double>, std::vector<uint32_t>> known;
  for (uint32_t s = 0; s < hierarchy.surfaces().size(); ++s) {
    const Surface& surface = hierarchy.surfaces()[s];
    const Polygon& of = hierarchy.scene().polygons[surface.polygon];
    const double share = hierarchy.scene().materials[of.material].specular;
    const bool front = surface.side == Side::kFront;
    const bool reflects = (of.sides & (front ? kFrontTakesPart : kBackTakesPart)) != 0;
    if (!reflects || !(share > 0)) continue;
    const ConvexPolygon& polygon = hierarchy.geometry(s);
    const Vec3 normal = polygon.Normal();
    std::vector<uint32_t>& alike = known[{hierarchy.plane_of(surface.polygon), share}];
    auto found = std::ranges::find_if(
        alike, [&](uint32_t p) { return glm::dot(planes[p].normal, normal) > 0; });
    if (found == alike.end()) {
      alike.push_back(static_cast<uint32_t>(planes.size()));
      planes.push_back({normal, glm::dot(normal, polygon.v[0]), share, 0, {}});
      found = alike.end() - 1;
    }
    planes[*found].surfaces.push_back(s);
    planes[*found].area_m2 += hierarchy.surface_area_m2(s);
  }
  return planes;
}

Mirrors::Mirrors(const Hierarchy& hierarchy, double accuracy)
    : hierarchy_(&hierarchy), planes_(MirrorPlanesOf(hierarchy)) {
  if (planes_.empty()) return;
  share_.assign(2 * hierarchy.scene().polygons.size(), 0.0);
  for (const MirrorPlane& plane : planes_) {
    for (const uint32_t s : plane.surfaces) {
      const Surface& surface = hierarchy.surfaces()[s];
      share_[2 * size_t{surface.polygon} + static_cast<size_t>(surface.side)] = plane.share;
    }
  }
  FindImages(kLeastShare * accuracy);
  PairImages();
}

// One reflection more each time, until none matters. images_ is the queue.
void Mirrors::FindImages(double least_share) {
  MirrorImage next;
  for (uint32_t p = 0; p < planes_.size() && images_.size() < kMostImages; ++p) {
    if (Extend({}, p, &next)) images_.push_back(next);
  }
  for (size_t i = 0; i < images_.size(); ++i) {
    for (uint32_t p = 0; p < planes_.size(); ++p) {
      if (p == images_[i].openings.back().plane || !Extend(images_[i], p, &next)) continue;
      const double most = MostThrough(next);
      if (most < least_share) continue;
      if (images_.size() < kMostImages) {
        images_.push_back(next);
      } else {
        missing_ = std::max(missing_, most);
      }
    }
  }
}

// False where no path can go that way.
bool Mirrors::Extend(const MirrorImage& from, uint32_t number, MirrorImage* to) const {
  const MirrorPlane& plane = planes_[number];
  MirrorOpening opening;
  opening.plane = number;
  opening.normal = from.image.Direction(plane.normal);
  opening.height_m = glm::dot(opening.normal, from.image.Point(plane.height_m * plane.normal));
  opening.to_scene = from.image.Inverse();
  const std::vector<Vec3> corners = CornersOf(opening);
  const auto any = [&](const std::vector<Vec3>& points, const MirrorOpening& of, double sign) {
    return std::ranges::any_of(
        points, [&](const Vec3& v) { return sign * of.HeightOf(v) > tolerance_m(); });
  };
  // Each opening lies behind those before it, those before the new one, and what passes any and
  // the new one passes those between.
  for (size_t i = 0; i < from.openings.size(); ++i) {
    const std::vector<Vec3> before = CornersOf(from.openings[i]);
    if (!any(corners, from.openings[i], -1) || !any(before, opening, 1)) return false;
    if (PassageThrough(*this, std::span(from.openings).subspan(i + 1), before, corners) ==
        Passage::kNone) {
      return false;
    }
  }
  if (from.openings.empty()) {
    // Something must lie before the mirror.
    const auto& vertices = hierarchy_->scene().vertices;
    if (std::ranges::none_of(vertices,
                             [&](const Vec3& v) { return opening.HeightOf(v) > tolerance_m(); })) {
      return false;
    }
  }
  *to = from;
  to->openings.push_back(std::move(opening));
  to->image = from.image * Reflection(plane.normal, plane.height_m);
  to->back = to->image.Inverse();
  to->share = from.share * plane.share;
  return true;
}

std::vector<Vec3> Mirrors::CornersOf(const MirrorOpening& opening) const {
  const Isometry there = opening.to_scene.Inverse();
  std::vector<Vec3> corners;
  for (const uint32_t s : planes_[opening.plane].surfaces) {
    const ConvexPolygon& polygon = hierarchy_->geometry(s);
    for (int i = 0; i < polygon.count; ++i) corners.push_back(there.Point(polygon.v[i]));
  }
  return corners;
}

// Of the light on its first and its last mirrors, what passes at most: form factor by the least
// distance, times the share that the mirrors leave.
double Mirrors::MostThrough(const MirrorImage& image) const {
  const MirrorOpening &first = image.openings.front(), &last = image.openings.back();
  const auto bounds_of = [&](const MirrorOpening& opening) {
    Bounds3 bounds;
    for (const Vec3& corner : CornersOf(opening)) bounds.Add(corner);
    return bounds;
  };
  const double distance = Distance(bounds_of(first), bounds_of(last));
  const double area = std::min(planes_[first.plane].area_m2, planes_[last.plane].area_m2);
  const double factor = area < std::numbers::pi * distance * distance
                            ? area / (std::numbers::pi * distance * distance)
                            : 1.0;
  return image.share * factor;
}

// Leaves out images whose paths backwards were not found, so that couplings stay symmetric.
void Mirrors::PairImages() {
  std::map<std::vector<uint32_t>, size_t> number;
  for (size_t i = 0; i < images_.size(); ++i) number[NumbersOf(images_[i])] = i;
  const auto reverse_of = [&](const MirrorImage& image) {
    std::vector<uint32_t> numbers = NumbersOf(image);
    std::ranges::reverse(numbers);
    const auto found = number.find(numbers);
    return found == number.end() ? images_.size() : found->second;
  };
  std::vector<uint32_t> place(images_.size(), kNone);
  std::vector<MirrorImage> kept;
  for (size_t i = 0; i < images_.size(); ++i) {
    const size_t reverse = reverse_of(images_[i]);
    if (reverse == images_.size()) {
      missing_ = std::max(missing_, MostThrough(images_[i]));
      continue;
    }
    place[i] = static_cast<uint32_t>(kept.size());
    kept.push_back(images_[i]);
    kept.back().reverse = static_cast<uint32_t>(reverse);
  }
  for (MirrorImage& image : kept) image.reverse = place[image.reverse];
  images_ = std::move(kept);
}

bool Mirrors::Has(std::span<const uint32_t> planes) const {
  return std::ranges::any_of(images_, [&](const MirrorImage& image) {
    return std::ranges::equal(image.openings, planes, {}, &MirrorOpening::plane);
  });
}

uint32_t Mirrors::PlaneOf(uint32_t polygon, Side side) const {
  for (uint32_t p = 0; p < planes_.size(); ++p) {
    for (const uint32_t s : planes_[p].surfaces) {
      const Surface& surface = hierarchy_->surfaces()[s];
      if (surface.polygon == polygon && surface.side == side) return p;
    }
  }
  return kNone;
}

uint32_t Mirrors::PolygonAt(uint32_t plane, const Vec3& point) const {
  const Vec3& normal = planes_[plane].normal;
  for (const uint32_t s : planes_[plane].surfaces) {
    const ConvexPolygon& polygon = hierarchy_->geometry(s);
    bool inside = true;
    for (int i = 0; inside && i < polygon.count; ++i) {
      const Vec3 along = polygon.v[(i + 1) % polygon.count] - polygon.v[i];
      inside = glm::dot(glm::cross(along, point - polygon.v[i]), normal) >= 0;
    }
    if (inside) return hierarchy_->surfaces()[s].polygon;
  }
  return kNone;
}

}  // namespace isolux
