// Sources side by side, ready for evaluation at many points of one surface: the inner loop of the
// gather. In single precision, in a frame whose third axis is the surface's normal and whose origin
// is near the points, so that nothing cancels: sides of sources and their moments about the origin
// are made in double.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/hierarchy/mirrors.h"
#include "worker/coupling/clip.h"
#include "worker/coupling/float_lanes.h"
#include "worker/coupling/lanes.h"
#include "worker/radiosity/exact_view.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {

// Axes of a surface: two in its plane, and its normal.
struct SurfaceFrame {
  Vec3 u{0.0}, v{0.0}, n{0.0};
};
SurfaceFrame FrameOf(const Vec3& normal);

// A point of the surface's plane, relative to the origin of a block and in its unit of length.
struct PlanePoint {
  float x = 0, y = 0;
};

// Eight polygons, of four sides each; what a triangle lacks, and polygons that lack, has length 0.
struct SourceOctet {
  // By side and axis: where it starts, its extent, and start × extent.
  std::array<std::array<FloatLanes, 3>, 4> corner{}, side{}, moment{};
  // Height of a point over the source's plane: height + slope_x x + slope_y y.
  FloatLanes height{}, slope_x{}, slope_y{};
  std::array<FloatLanes, 3> radiosity{};  // by channel, in units of 1/scale W/m²
  FloatLanes visibility{};                // of the link
  // W/m² over the form factor, summed over channels, of what is in doubt: all of it, as far as it
  // asks for a ray, and times its doubt.
  FloatLanes brings{}, doubt{};
  // Form factor over the W/m² it would bring, where what is seen of it can be found exactly; else
  // infinity.
  FloatLanes exact_per_w_m2 = SplatFloat(std::numeric_limits<float>::infinity());
  UInt32Lanes seed{};
};

// Eight clusters, as disks at their centres.
struct ClusterOctet {
  std::array<FloatLanes, 3> centre{};
  FloatLanes facing{};                    // area that faces the surface, in squared units
  std::array<FloatLanes, 3> radiosity{};  // times visibility, in units of 1/scale W/m²
};

// How closely points of a leaf look at sources in doubt, by what these bring.
struct GatherCare {
  double rays_per_doubt_w_m2 = 0;  // that it brings times the doubt of its link
  double ray_from_w_m2 = 0;        // a source that brings so much gets one however small its doubt
  // What is seen of it is found exactly where it can be.
  double exact_from_w_m2 = std::numeric_limits<double>::infinity();
  double tolerance_w_m2 = 0;  // until the error of rays that disagree is below that
};

// Whether panes of glass may stand before a source, and what they leave of it: of each point anew
// where all of it is seen or all of it is behind the same panes, else the mean over what passes.
struct Glazed {
  enum class Kind : uint8_t { kNot, kByPoint, kMean } kind = Kind::kNot;
  bool all = false;  // of it is behind the same panes
  std::array<float, 3> mean = {1, 1, 1};
};

// A polygon as the target of rays. In the scene's coordinates.
struct RayTarget {
  ConvexPolygon polygon;
  std::optional<PolygonSampler> sampler;  // of the polygon drawn in; made when first asked for
  Vec3 normal{0.0};
  uint32_t surface_polygon = 0;
  uint64_t seed = 0;
  // The element, of a source that is partly hidden and varies: rays look up the leaf they meet.
  // kNoNode for others.
  uint32_t varying = 0xffffffffu;
  const MirrorImage* image = nullptr;  // the polygon is of that; null: seen straight
  Glazed glazed;
  ViewFromLeaf view;  // where what is seen of it is found exactly
};

// What the links of one node of the tree bring to points below it.
class SourceBlock {
 public:
  // `inverse_unit_m`: 1 over the unit of length, a power of two near the scene's extent, so that
  // no scale of the scene leaves the range of single precision, or changes a bit.
  void Start(const SurfaceFrame& frame, const Vec3& origin, double inverse_unit_m);

  struct Strength {
    Lanes radiosity{};  // by channel, in units of 1/scale W/m²
    double visibility = 1;
    double brings = 0, doubt = 0;
    double exact_per_w_m2 = std::numeric_limits<double>::infinity();
    uint64_t seed = 0;
  };
  // A polygon wholly in front of the surface's plane; up to five corners, which the target gets.
  void Add(const ClippedPolygon& polygon, const Vec3& normal, const Strength& strength,
           const RayTarget& target);
  void AddCluster(const Vec3& centre, double facing_m2, double visibility, const Lanes& radiosity);
  void AddEven(const Lanes& arriving);  // alike all over the surface, in the same units

  PlanePoint At(const Vec3& point) const {
    const Vec3 d = inverse_unit_m_ * (point - origin_);
    return {static_cast<float>(glm::dot(frame_.u, d)), static_cast<float>(glm::dot(frame_.v, d))};
  }

  double unit_m() const { return 1 / inverse_unit_m_; }
  std::span<const SourceOctet> octets() const { return octets_; }
  std::span<const ClusterOctet> clusters() const { return cluster_octets_; }
  // Of lane l of octet o: number 8 o + l.
  RayTarget& target(size_t number) { return targets_[number]; }
  const std::array<int64_t, 3>& even() const { return even_; }

 private:
  void AddPart(std::span<const Vec3> corners, const Vec3& normal, const Strength& strength,
               const RayTarget& target);
  Vec3 ToFrame(const Vec3& d) const {
    return {glm::dot(frame_.u, d), glm::dot(frame_.v, d), glm::dot(frame_.n, d)};
  }
  Vec3 PointToFrame(const Vec3& point) const {
    return ToFrame(inverse_unit_m_ * (point - origin_));
  }

  SurfaceFrame frame_;
  Vec3 origin_{0.0};
  double inverse_unit_m_ = 1;
  std::vector<SourceOctet> octets_;
  std::vector<ClusterOctet> cluster_octets_;
  std::vector<RayTarget> targets_;
  size_t cluster_count_ = 0;
  std::array<int64_t, 3> even_{};
};

// Form factors from a point to eight polygons ([Lambert60]; [BaumRushmeierWinget89], eq. 4), in
// [0, 1]; 0 for those whose back the point sees. Relative error about 1e-6 of the distance over the
// size of the source.
FloatLanes FormFactors(const SourceOctet& octet, PlanePoint at);

// The same to eight clusters: their facing area as a disk at their centre, seen by the cosine;
// bounded however near it is.
FloatLanes FormFactors(const ClusterOctet& octet, PlanePoint at);

}  // namespace isolux
