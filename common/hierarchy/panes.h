// The panes of glass of a scene, found by segments: what they leave of light from one point to
// another, and whether any may stand between two polygons at all. A tree of their own boxes: no
// other ray knows of them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/hierarchy/mirrors.h"
#include "common/scene/box_tree.h"
#include "common/scene/glazing.h"
#include "common/scene/scene.h"

namespace isolux {

// Whether all light between two bodies crosses the same panes, or some of it, or none crosses any.
enum class Crossing : uint8_t { kNone, kSome, kAll };

class Panes {
 public:
  // extent_m: of the scene. `grey`: of each glass the mean of its channels at normal incidence
  // counts.
  Panes(const Glazing& glazing, double extent_m, bool grey);

  bool is_grey() const { return grey_; }
  size_t size() const { return planes_.size(); }

  // What is left of light on the open segment: the product over the panes it crosses. Panes that
  // meet in one plane count once where they meet.
  Rgb Along(const Vec3& from, const Vec3& to) const;
  // The same to a point of an image, by way of the mirrors.
  Rgb Along(const Vec3& from, const Vec3& to, const MirrorImage& image) const;

  // Of all segments between the hulls of two sets of points, by their corners alone. kNone is
  // proved; kAll and kSome are as far as the corners tell.
  Crossing Between(std::span<const Vec3> here, std::span<const Vec3> there) const;

 private:
  struct Plane {
    Vec3 normal{0.0}, point{0.0};
    uint32_t first = 0, count = 0;  // of its corners
    uint32_t glass = 0;
    bool is_half = false;
  };

  double HeightOf(const Plane& plane, const Vec3& x) const {
    return glm::dot(plane.normal, x - plane.point);
  }
  // Whether a point of the plane is within the pane, its border included.
  bool Holds(const Plane& plane, const Vec3& x) const;
  Rgb Left(uint32_t glass, double cosine) const;
  Crossing Across(const Plane& plane, std::span<const Vec3> here,
                  std::span<const Vec3> there) const;

  std::vector<Glass> glasses_;
  std::vector<Rgb> left_;  // of each glass by the cosine
  std::vector<Plane> planes_;
  std::vector<Vec3> corners_, inwards_;
  std::optional<BoxTree> tree_;
  double tolerance_m_ = 0;
  bool grey_ = true;
};

}  // namespace isolux
