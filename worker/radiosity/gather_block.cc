#include "worker/radiosity/gather_block.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isolux {

SurfaceFrame FrameOf(const Vec3& normal) {
  const Vec3 size = glm::abs(normal);
  const Vec3 axis = size.x <= size.y && size.x <= size.z ? Vec3(1, 0, 0)
                    : size.y <= size.z                   ? Vec3(0, 1, 0)
                                                         : Vec3(0, 0, 1);
  const Vec3 u = glm::normalize(glm::cross(axis, normal));
  return {u, glm::cross(normal, u), normal};
}

void SourceBlock::Start(const SurfaceFrame& frame, const Vec3& origin, double inverse_unit_m) {
  frame_ = frame;
  origin_ = origin;
  inverse_unit_m_ = inverse_unit_m;
  octets_.clear();
  cluster_octets_.clear();
  targets_.clear();
  cluster_count_ = 0;
  even_ = {};
}

void SourceBlock::Add(const ClippedPolygon& polygon, const Vec3& normal, const Strength& strength,
                      const RayTarget& target) {
  const std::span<const Vec3> corners = polygon.corners();
  AddPart(corners.first(std::min<size_t>(4, corners.size())), normal, strength, target);
  if (corners.size() <= 4) return;
  const std::array<Vec3, 3> rest = {corners[0], corners[3], corners[4]};
  AddPart(rest, normal, strength, target);
}

void SourceBlock::AddPart(std::span<const Vec3> corners, const Vec3& normal,
                          const Strength& strength, const RayTarget& target) {
  const size_t lane = targets_.size() % 8;
  if (lane == 0) octets_.emplace_back();
  SourceOctet& octet = octets_.back();
  std::array<Vec3, 4> local;
  for (size_t k = 0; k < corners.size(); ++k) {
    local[k] = PointToFrame(corners[k]);
    // What was cut off at the plane, or touches it, lies in it: then its moment is exact.
    if (std::abs(local[k].z) < 1e-12 * glm::length(local[k])) local[k].z = 0;
  }
  for (size_t k = 0; k < corners.size(); ++k) {
    const Vec3 side = local[(k + 1) % corners.size()] - local[k];
    const Vec3 moment = glm::cross(local[k], side);
    for (int c = 0; c < 3; ++c) {
      octet.corner[k][c][lane] = static_cast<float>(local[k][c]);
      octet.side[k][c][lane] = static_cast<float>(side[c]);
      octet.moment[k][c][lane] = static_cast<float>(moment[c]);
    }
  }
  const Vec3 n = ToFrame(normal);
  octet.height[lane] = static_cast<float>(-glm::dot(n, local[0]));
  octet.slope_x[lane] = static_cast<float>(n.x);
  octet.slope_y[lane] = static_cast<float>(n.y);
  for (int c = 0; c < 3; ++c) {
    octet.radiosity[c][lane] = static_cast<float>(strength.radiosity[c]);
  }
  octet.visibility[lane] = static_cast<float>(strength.visibility);
  octet.brings[lane] = static_cast<float>(strength.brings);
  octet.doubt[lane] = static_cast<float>(strength.doubt);
  octet.exact_per_w_m2[lane] = static_cast<float>(strength.exact_per_w_m2);
  octet.seed[lane] = static_cast<uint32_t>(strength.seed);
  targets_.push_back(target);
  targets_.back().polygon.count = static_cast<int>(corners.size());
  std::copy(corners.begin(), corners.end(), targets_.back().polygon.v.begin());
}

void SourceBlock::AddCluster(const Vec3& centre, double facing_m2, double visibility,
                             const Lanes& radiosity) {
  const size_t lane = cluster_count_++ % 8;
  if (lane == 0) cluster_octets_.emplace_back();
  ClusterOctet& octet = cluster_octets_.back();
  const Vec3 local = PointToFrame(centre);
  for (int c = 0; c < 3; ++c) {
    octet.centre[c][lane] = static_cast<float>(local[c]);
    octet.radiosity[c][lane] = static_cast<float>(visibility * radiosity[c]);
  }
  octet.facing[lane] = static_cast<float>(facing_m2 * inverse_unit_m_ * inverse_unit_m_);
}

void SourceBlock::AddEven(const Lanes& arriving) {
  for (int c = 0; c < 3; ++c) even_[c] += static_cast<int64_t>(arriving[c]);
}

FloatLanes FormFactors(const SourceOctet& octet, PlanePoint at) {
  FloatLanes sum{};
  for (int k = 0; k < 4; ++k) {
    const auto& side = octet.side[k];
    const FloatLanes ax = octet.corner[k][0] - at.x;
    const FloatLanes ay = octet.corner[k][1] - at.y;
    const FloatLanes az = octet.corner[k][2];
    // corner × side about the point: the moment about the origin less that of the shift.
    const FloatLanes mx = octet.moment[k][0] - at.y * side[2];
    const FloatLanes my = octet.moment[k][1] + at.x * side[2];
    const FloatLanes mz = octet.moment[k][2] - at.x * side[1] + at.y * side[0];
    const FloatLanes length = SquareRoot(mx * mx + my * my + mz * mz);
    const FloatLanes dot = ax * (ax + side[0]) + ay * (ay + side[1]) + az * (az + side[2]);
    const FloatLanes angle = Atan2Upper(length, dot);
    // A side through the point, or none, has no angle of its own; tiny moments would divide by 0.
    sum += Select(length > 1e-30F, angle * mz / Maximum(length, SplatFloat(1e-30F)), FloatLanes{});
  }
  const FloatLanes factor = Minimum(
      Maximum(sum * static_cast<float>(-0.5 / std::numbers::pi), FloatLanes{}), SplatFloat(1));
  const FloatLanes height = octet.height + octet.slope_x * at.x + octet.slope_y * at.y;
  return Select(height > 0.0F, factor, FloatLanes{});
}

FloatLanes FormFactors(const ClusterOctet& octet, PlanePoint at) {
  const FloatLanes x = octet.centre[0] - at.x, y = octet.centre[1] - at.y, z = octet.centre[2];
  const FloatLanes distance2 = x * x + y * y + z * z;
  const FloatLanes cosine = Maximum(z, FloatLanes{}) / SquareRoot(distance2 + 1e-30F);
  // A/(π d² + A), a disk's form factor seen face on, about; at most 1.
  return cosine * octet.facing /
         (static_cast<float>(std::numbers::pi) * distance2 + octet.facing + 1e-30F);
}

}  // namespace isolux
