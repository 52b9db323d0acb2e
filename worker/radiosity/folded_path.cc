#include "worker/radiosity/folded_path.h"

#include <algorithm>
#include <optional>

#include "worker/radiosity/escape.h"

namespace isolux {
namespace {

// Rays are followed until less than this is left of their light.
constexpr double kLeastLight = 1e-3;
constexpr int kMostReflections = 1000;

// Where a leg of a path ends.
struct Goal {
  Vec3 point{0.0};
  uint32_t polygon = 0;
};

Vec3 PointOf(const std::array<FloatLanes, 3>& points, int i) {
  return {points[0][i], points[1][i], points[2][i]};
}

}  // namespace

uint32_t VisibleThrough(const RayScene& rays, const Mirrors& mirrors, const MirrorImage& image,
                        const RayPacket& packet, bool look) {
  uint32_t passing = packet.valid;
  std::array<Vec3, RayScene::kPacket> at;
  std::array<uint32_t, RayScene::kPacket> at_polygon = packet.from_polygon;
  std::array<double, RayScene::kPacket> way{};  // share of it that is behind
  for (int i = 0; i < RayScene::kPacket; ++i) at[i] = PointOf(packet.from, i);
  const auto leg_to = [&](const auto& next) {
    RayPacket leg;
    leg.from_polygon.fill(0);
    for (int i = 0; i < RayScene::kPacket; ++i) {
      if ((passing >> i & 1) == 0) continue;
      const std::optional<Goal> goal = next(i);
      if (!goal) {
        passing &= ~(1U << i);
        continue;
      }
      leg.Set(i, {at[i], goal->point, at_polygon[i], goal->polygon});
      at[i] = goal->point;
      at_polygon[i] = goal->polygon;
    }
    if (look && passing != 0) passing &= rays.Visible(leg);
  };
  for (const MirrorOpening& opening : image.openings) {
    if (passing == 0) return 0;
    leg_to([&](int i) -> std::optional<Goal> {
      const Vec3 from = PointOf(packet.from, i), to = PointOf(packet.to, i);
      const double before = opening.HeightOf(from), behind = -opening.HeightOf(to);
      if (!(before > 0 && behind > 0)) return {};
      const double share = before / (before + behind);
      if (share < way[i]) return {};
      way[i] = share;
      const Vec3 point = opening.to_scene.Point(from + share * (to - from));
      const uint32_t polygon = mirrors.PolygonAt(opening.plane, point);
      if (polygon == Mirrors::kNone) return {};
      return Goal{point, polygon};
    });
  }
  leg_to([&](int i) -> std::optional<Goal> {
    return Goal{image.back.Point(PointOf(packet.to, i)), packet.to_polygon[i]};
  });
  return passing;
}

RayEnd EndOf(const RayScene& rays, const Mirrors& mirrors, Escape ray, RayHit hit,
             const Hierarchy& hierarchy, const Panes* panes) {
  RayEnd end;
  for (end.hit = hit; end.reflections < kMostReflections; ++end.reflections) {
    end.direction = ray.direction;
    end.from = ray.from;
    const double share =
        hit.polygon == RayHit::kNothing ? 0.0 : mirrors.ShareOf(hit.polygon, hit.side);
    if (end.share * share < kLeastLight) break;
    end.share *= share;
    const Vec3 normal = SideGeometry(hierarchy.scene(), hit.polygon, hit.side).Normal();
    if (panes != nullptr) {
      end.left *= panes->Along(ray.from, ray.from + hit.distance * ray.direction);
    }
    ray.from += hit.distance * ray.direction;
    end.way_m += hit.distance;
    ray.direction -= 2 * glm::dot(normal, ray.direction) * normal;
    ray.from_polygon = hit.polygon;
    end.hit = hit = rays.Trace({ray}, 1)[0];
  }
  return end;
}

double EscapedShare(const RayScene& rays, const Mirrors& mirrors, const Escape& ray,
                    const RayHit& hit, const Hierarchy& hierarchy) {
  if (TakesPart(hierarchy.scene(), hit) && mirrors.empty()) return 0;
  const RayEnd end = EndOf(rays, mirrors, ray, hit, hierarchy);
  return TakesPart(hierarchy.scene(), end.hit) ? 0 : end.share;
}

}  // namespace isolux
