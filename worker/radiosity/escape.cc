#include "worker/radiosity/escape.h"

#include <algorithm>
#include <cmath>

#include "common/util/disjoint_sets.h"
#include "common/util/random.h"
#include "worker/radiosity/folded_path.h"
#include "worker/radiosity/openings.h"
#include "worker/radiosity/polygon_sampler.h"

namespace isolux {
namespace {

// Over the whole scene, half of them in proportion to area, half to emitted power.
constexpr double kScoutRays = 131072;
constexpr double kPowerRays = 16384;  // over all leaves that emit, in proportion to power
constexpr double kClosedRays = 15;    // times 1/(a (1 − ρ̄)): see the header

// A packet of cosine-distributed rays from points of a polygon.
std::array<Escape, RayScene::kPacket> CosineRays(const ConvexPolygon& polygon, uint32_t source,
                                                 Random& random) {
  const Vec3 n = polygon.Normal();
  const Vec3 helper = std::abs(n.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 s = glm::normalize(glm::cross(n, helper));
  const Vec3 t = glm::cross(n, s);
  std::array<Escape, RayScene::kPacket> rays;
  for (Escape& ray : rays) {
    // A uniform point of the unit disk, raised to the hemisphere (Malley); by rejection, since the
    // C library's sine differs between machines.
    double x = 0, y = 0;
    do {
      x = 2 * random.Unit() - 1;
      y = 2 * random.Unit() - 1;
    } while (x * x + y * y >= 1);
    const double height = std::sqrt(std::max(1e-12, 1 - x * x - y * y));
    const double u = random.Unit();
    ray = {SamplePolygon(polygon, u, random.Unit()), x * s + y * t + height * n, source};
  }
  return rays;
}

uint8_t SideFlag(Side side) {
  return side == Side::kFront ? kFrontTakesPart | kFrontEmits : kBackTakesPart | kBackEmits;
}

struct Scouted {
  uint32_t rays = 0;
  uint32_t escaped = 0;
  double lost = 0;            // of the rays' light, mirrors followed
  std::vector<uint32_t> met;  // surfaces
};

}  // namespace

bool TakesPart(const Scene& scene, const RayHit& hit) {
  return hit.polygon != RayHit::kNothing &&
         (scene.polygons[hit.polygon].sides & SideFlag(hit.side)) != 0;
}

Scout ScoutEscapes(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const TranslucentSheets& sheets, double accuracy, uint64_t seed,
                   ThreadPool& pool) {
  const Scene& scene = hierarchy.scene();
  const auto surfaces = hierarchy.surfaces();
  const double total_area = hierarchy.clusters()[0].area_m2;
  const double total_power = Sum(hierarchy.emitted_w());
  std::vector<std::array<uint32_t, 2>> surface_of(scene.polygons.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    surface_of[surfaces[s].polygon][static_cast<int>(surfaces[s].side)] = s;
  }
  std::vector<Scouted> scouted(surfaces.size());
  pool.For(surfaces.size(), 64, [&](size_t begin, size_t end, int) {
    for (size_t s = begin; s < end; ++s) {
      const double area = hierarchy.surface_area_m2(s);
      const double power = total_power > 0 ? area * Sum(surfaces[s].exitance) / total_power : 0.0;
      const double share = 0.5 * (area / total_area + power);
      const int packets =
          std::clamp(static_cast<int>(kScoutRays / RayScene::kPacket * share), 2, 4096);
      Random random(Hash(seed, 0x5c0u, s));
      for (int k = 0; k < packets; ++k) {
        const auto escapes = CosineRays(DrawnIn(hierarchy.geometry(s), rays.coordinate_noise_m()),
                                        surfaces[s].polygon, random);
        const auto hits = rays.Trace(escapes, RayScene::kPacket);
        for (int i = 0; i < RayScene::kPacket; ++i) {
          const RayHit& hit = hits[i];
          ++scouted[s].rays;
          scouted[s].lost += EscapedShare(rays, mirrors, escapes[i], hit, hierarchy);
          if (TakesPart(scene, hit)) {
            scouted[s].met.push_back(surface_of[hit.polygon][static_cast<int>(hit.side)]);
          } else {
            ++scouted[s].escaped;
          }
        }
      }
    }
  });
  DisjointSets components(surfaces.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    for (const uint32_t met : scouted[s].met) components.Join(s, met);
  }
  JoinPastFreeEdges(hierarchy, rays, seed, pool, &components);
  struct Pool {
    uint64_t rays = 0, escaped = 0;
    double area = 0, reflecting = 0;
  };
  std::vector<Pool> pools(surfaces.size());
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    Pool& p = pools[components.Find(s)];
    const Rgb rho = surfaces[s].reflectance + sheets.TransmittanceOf(s);
    p.rays += scouted[s].rays;
    p.escaped += scouted[s].escaped;
    p.area += hierarchy.surface_area_m2(s);
    p.reflecting += hierarchy.surface_area_m2(s) * std::max({rho.x, rho.y, rho.z});
  }
  Scout scout{std::vector<float>(surfaces.size()), std::vector<uint32_t>(surfaces.size()),
              std::vector<uint8_t>(surfaces.size()), std::vector<uint32_t>(surfaces.size())};
  for (uint32_t s = 0; s < surfaces.size(); ++s) {
    scout.component[s] = components.Find(s);
    const Pool& p = pools[scout.component[s]];
    const double absorbed = std::max(1e-6, 1 - p.reflecting / p.area);
    scout.rays[s] = scouted[s].rays;
    scout.escape[s] = static_cast<float>(scouted[s].lost) / static_cast<float>(scouted[s].rays);
    scout.closed[s] =
        p.escaped == 0 && static_cast<double>(p.rays) * accuracy * absorbed >= kClosedRays;
  }
  return scout;
}

int EscapeRaysOf(double share_of_emitted_power) {
  const double packets = std::round(kPowerRays / RayScene::kPacket * share_of_emitted_power);
  return RayScene::kPacket * std::max(kEscapeRays / RayScene::kPacket, static_cast<int>(packets));
}

double EscapeShare(const Hierarchy& hierarchy, const RayScene& rays, const Mirrors& mirrors,
                   const NodeId& id, const ConvexPolygon& polygon, double prior, int ray_count,
                   uint64_t seed) {
  Random random(Hash(seed, 0xe5c0u, Hash(id.surface, id.path)));
  double escaped = 0;
  for (int k = 0; k < ray_count / RayScene::kPacket; ++k) {
    const auto escapes = CosineRays(DrawnIn(polygon, rays.coordinate_noise_m()),
                                    hierarchy.surfaces()[id.surface].polygon, random);
    const auto hits = rays.Trace(escapes, RayScene::kPacket);
    for (int i = 0; i < RayScene::kPacket; ++i) {
      escaped += EscapedShare(rays, mirrors, escapes[i], hits[i], hierarchy);
    }
  }
  return (escaped + kPriorRays * prior) / (ray_count + kPriorRays);
}

double EscapeDeviation(double share, double ray_count) {
  const double v = (share * ray_count + 0.5) / (ray_count + 1);
  return std::sqrt(v * (1 - v) / ray_count);
}

}  // namespace isolux
