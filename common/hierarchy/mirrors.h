// Plane mirrors and the images they make. A side whose material reflects specularly is a mirror;
// mirrors in one plane that reflect alike are one plane of mirrors. Light that meets the planes a₁,
// a₂ … a_k one after the other goes straight from a point to the image R_a₁ R_a₂ … R_a_k of its
// goal, through the mirrors as openings: R_a₁ … R_a_(j−1) of those of a_j.
#pragma once

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <span>
#include <string>
#include <vector>

#include "common/hierarchy/hierarchy.h"

namespace isolux {

// x → turn x + shift, a product of reflections.
struct Isometry {
  glm::dmat3 turn{1.0};
  Vec3 shift{0.0};
  bool reverses = false;  // an odd number of reflections

  Vec3 Point(const Vec3& x) const { return turn * x + shift; }
  Vec3 Direction(const Vec3& d) const { return turn * d; }
  ConvexPolygon Of(const ConvexPolygon& polygon) const;  // counter-clockwise about its normal
  Isometry Inverse() const;
};
Isometry operator*(const Isometry& last, const Isometry& first);

struct MirrorPlane {
  Vec3 normal{0.0};  // towards where it reflects
  double height_m = 0;
  double share = 0;  // of the light, that is reflected as by a mirror
  double area_m2 = 0;
  std::vector<uint32_t> surfaces;
};

// A plane of mirrors that a path meets, as it lies where the path is straight.
struct MirrorOpening {
  uint32_t plane = 0;  // number of the plane
  Vec3 normal{0.0};    // against the path
  double height_m = 0;
  Isometry to_scene;  // back to where its mirrors are

  double HeightOf(const Vec3& point) const { return glm::dot(normal, point) - height_m; }
};

struct MirrorImage {
  std::vector<MirrorOpening> openings;  // in the order of the path
  Isometry image, back;                 // from the scene to the image, and back
  uint32_t reverse = 0;                 // number of the image that the same paths see backwards
  double share = 1;                     // of the light, that the mirrors leave
};

class Mirrors {
 public:
  static constexpr size_t kMostPlanes = 512, kMostImages = 2048;

  Mirrors() = default;  // none
  // All images that may bring a share of the light on the mirrors that matters for the accuracy,
  // or as many as may be, those of the fewest reflections first. Keeps a pointer to the hierarchy.
  Mirrors(const Hierarchy& hierarchy, double accuracy);

  bool empty() const { return planes_.empty(); }
  std::span<const MirrorPlane> planes() const { return planes_; }
  std::span<const MirrorImage> images() const { return images_; }
  // Of the light on the mirrors, what one more image would have brought at most: 0 where none was
  // left out for want of room.
  double missing() const { return missing_; }
  // Whether there is an image for light that meets these planes one after the other.
  bool Has(std::span<const uint32_t> planes) const;
  // Of the plane that a side is a mirror of; kNone where it is none.
  uint32_t PlaneOf(uint32_t polygon, Side side) const;
  // Points within it of a plane or side count as on it.
  double tolerance_m() const { return 1e-6 * hierarchy_->extent_m(); }

  // Share of the light that a side reflects as a mirror.
  double ShareOf(uint32_t polygon, Side side) const {
    return empty() ? 0.0 : share_[2 * size_t{polygon} + static_cast<size_t>(side)];
  }
  // The polygon of the mirror of a plane that holds this point, Hierarchy's number of it.
  static constexpr uint32_t kNone = 0xffffffffu;
  uint32_t PolygonAt(uint32_t plane, const Vec3& point) const;
  const ConvexPolygon& geometry(uint32_t surface) const { return hierarchy_->geometry(surface); }

 private:
  void FindImages(double least_share);
  bool Extend(const MirrorImage& from, uint32_t plane, MirrorImage* to) const;
  std::vector<Vec3> CornersOf(const MirrorOpening& opening) const;
  double MostThrough(const MirrorImage& image) const;
  void PairImages();

  const Hierarchy* hierarchy_ = nullptr;
  std::vector<MirrorPlane> planes_;
  std::vector<MirrorImage> images_;
  std::vector<double> share_;  // by polygon and side
  double missing_ = 0;
};

// Whether what lies between the corners of two convex bodies, the second where the path is
// straight, passes mirrors.
enum class Passage : uint8_t { kNone, kSome, kAll };
Passage PassageThrough(const Mirrors& mirrors, std::span<const MirrorOpening> openings,
                       std::span<const Vec3> here, std::span<const Vec3> there);

// The planes of mirrors of a scene.
std::vector<MirrorPlane> MirrorPlanesOf(const Hierarchy& hierarchy);

}  // namespace isolux
